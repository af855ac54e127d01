"""A click picks the place on the block that is meant; pairs are listed, marked, removed, held and undone."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from tests.addon.picked import NAMES, hit, line, pick, pick_ring
from tests.addon.shown_run import library, objects, opened, show


@pytest.fixture(scope="module")
def shown(cabletwin, rendered, finished, tmp_path_factory):
    return show(rendered, finished.folder, tmp_path_factory.mktemp("shown"))


@pytest.fixture
def state(shown):
    found = opened(shown)
    bpy.ops.cabletwin.mosaic_show_all()
    return found


def test_a_line_of_sight_meets_the_block_that_looks_at_it(state):
    for k, name in enumerate(NAMES):
        met = hit(90 * k, 0.2)
        assert met.block == name
        x, y, z = met.point
        assert math.hypot(x, z) == pytest.approx(0.0555, abs=0.002)
        assert y == pytest.approx(0.2, abs=0.001)
        assert met.distance_m == pytest.approx(0.3 - math.hypot(x, z), abs=0.001)


def test_a_line_past_the_cable_meets_nothing(state):
    picking, context = library("results.picking"), bpy.context
    origin, direction = line(0, 0.2)
    past = origin + Vector((0, 0, 0.2))
    assert picking.cast(context.scene, context.view_layer, past, direction) is None


def test_a_line_from_far_off_meets_the_same_point(state):
    picking, context = library("results.picking"), bpy.context
    near = hit(0, 0.2, "Block1").point.copy()
    origin, direction = line(0, 0.2, standoff_m=picking.NEAR_M)
    far = picking.cast(context.scene, context.view_layer, origin, direction, ["Block1"])
    assert (far.point - near).length < 1e-5


def test_hidden_blocks_are_not_met(state):
    objects("Block meshes")["Block1"].hide_set(True)
    assert hit(0, 0.2).block != "Block1"
    assert hit(0, 0.2, "Block1") is None


def test_points_are_in_the_blocks_own_frame(state):
    item = objects("Block meshes")["Block2"]
    still = hit(90, 0.2, "Block2").point.copy()
    item.matrix_world.translation += Vector((0, 0, -0.004))
    bpy.context.view_layer.update()
    assert (hit(90, 0.2, "Block2").point - still).length < 1e-5


def test_a_pair_is_marked_on_both_blocks_and_tells_its_gap(state):
    assert pick("Block1", "Block2", 45, 0.2, aside_m=0.0015) == {"FINISHED"}
    (pair,) = state.mosaic.pairs
    assert (pair.block_a, pair.block_b) == ("Block1", "Block2")
    assert pair.residual_mm == pytest.approx(1.5, abs=0.1)
    assert state.mosaic.way == "BY_HAND"
    marks = objects("Pairs")
    numbered = {name for name, mark in marks.items() if "cabletwin_label" in mark}
    assert numbered == {"1"}  # they lie too near for two
    for number, name, point in (("1", "Block1", pair.point_a), ("1′", "Block2", pair.point_b)):
        mark = marks[number]
        block = objects("Block meshes")[name]
        np.testing.assert_allclose(mark.location, block.matrix_world @ point, atol=1e-6)


def test_partners_that_lie_apart_have_a_number_each(state):
    pick("Block1", "Block2", 45, 0.2, aside_m=0.03)
    assert {mark["cabletwin_label"] for mark in objects("Pairs").values()} == {"1", "1′"}


def test_a_mark_behind_the_cable_has_no_number_over_what_is_in_front(cabletwin):
    """Looking along -z from above, and from a camera beside the cable."""
    in_front = cabletwin.overlay.is_in_front
    above, below = Vector((0.01, 0.2, 0.055)), Vector((0.01, 0.2, -0.055))
    assert in_front(above, Matrix.Translation((0, 0, -1)), perspective=False)
    assert not in_front(below, Matrix.Translation((0, 0, -1)), perspective=False)
    beside = Matrix.LocRotScale((0.3, 0.2, 0.0), Euler((math.pi / 2, 0, math.pi / 2)), None).inverted()
    near, far, grazing = Vector((0.055, 0.2, 0)), Vector((-0.055, 0.2, 0)), Vector((0.005, 0.2, 0.054))
    assert [in_front(p, beside, perspective=True) for p in (near, far, grazing)] == [True, False, False]


def test_one_block_twice_is_refused(state):
    with pytest.raises(RuntimeError, match="both points are on Block1; pick the partner on another block"):
        pick("Block1", "Block1", 10, 0.2)
    assert len(state.mosaic.pairs) == 0


def test_the_chosen_pair_is_held_instead_of_the_first(state):
    pick("Block1", "Block2", 45, 0.1)
    pick("Block2", "Block3", 135, 0.2)
    pick("Block1", "Block2", 45, 0.3, aside_m=0.001)
    assert state.mosaic.held() == [True, True, False]
    last = tuple(state.mosaic.pairs[2].point_b)
    assert bpy.ops.cabletwin.mosaic_hold() == {"FINISHED"}
    assert tuple(state.mosaic.pairs[0].point_b) == last
    assert state.mosaic.held() == [True, False, True]
    bpy.ops.cabletwin.mosaic_fit()
    # a turn takes most of the millimetre aside: what the other pair keeps is the difference of two lengths
    assert state.mosaic.pairs[0].residual_mm < 0.0001 < state.mosaic.pairs[1].residual_mm


def test_removing_a_pair_takes_its_marks_along(state):
    pick_ring()
    state.mosaic.pair_index = 1
    assert bpy.ops.cabletwin.mosaic_remove() == {"FINISHED"}
    assert [p.block_a for p in state.mosaic.pairs] == ["Block1", "Block3", "Block4"]
    assert len(objects("Pairs")) == 6
    bpy.ops.cabletwin.mosaic_clear()
    assert objects("Pairs") == {}


def test_undo_takes_back_one_pair_at_a_time(state):
    bpy.ops.ed.undo_push(message="before")
    for k in range(2):
        pick(NAMES[k], NAMES[k + 1], 45 + 90 * k, 0.2)
        bpy.ops.ed.undo_push(message="pair")
    for left in (1, 0):
        bpy.ops.ed.undo()
        assert len(bpy.context.scene.cabletwin.mosaic.pairs) == left
        assert len(objects("Pairs")) == 2 * left
    bpy.ops.ed.redo()
    assert len(bpy.context.scene.cabletwin.mosaic.pairs) == 1


def test_a_seam_is_looked_at_with_the_other_blocks_hidden(state):
    state.mosaic.block_a, state.mosaic.block_b = "Block1", "Block2"
    assert bpy.ops.cabletwin.mosaic_look() == {"FINISHED"}
    seen = {name for name, item in objects("Block meshes").items() if item.visible_get()}
    assert seen == {"Block1", "Block2"}
    middle, out, length_m = library("results.joined").seam(bpy.context.scene, "Block1", "Block2")
    half = math.sqrt(0.5)
    np.testing.assert_allclose(out, (half, 0, -half), atol=0.02)
    travel_m = state.survey.travel
    assert middle.y == pytest.approx(travel_m / 2, abs=0.03)
    assert travel_m < length_m < 1.5 * travel_m
    bpy.ops.cabletwin.mosaic_show_all()
    assert all(item.visible_get() for item in objects("Block meshes").values())


def test_blocks_that_lie_opposite_have_no_seam(state):
    state.mosaic.block_a, state.mosaic.block_b = "Block1", "Block3"
    with pytest.raises(RuntimeError, match="Block1 and Block3 do not meet; choose two neighbours"):
        bpy.ops.cabletwin.mosaic_look()
