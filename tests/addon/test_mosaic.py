"""Pairs picked on the block meshes join the blocks as the command line does with the same file."""

import csv
import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

from tests.addon.shown_run import library, moved, objects, opened, reloaded, show
from tests.command import pipeline

NAMES = ("Block1", "Block2", "Block3", "Block4")


@pytest.fixture(scope="module")
def shown(cabletwin, rendered, finished, tmp_path_factory):
    return show(rendered, finished.folder, tmp_path_factory.mktemp("shown"))


@pytest.fixture
def state(shown):
    found = opened(shown)
    bpy.ops.cabletwin.mosaic_show_all()
    return found


def line(azimuth_deg, y_m, standoff_m=0.3):
    """From a camera's place to the axis."""
    out = Vector((math.cos(math.radians(azimuth_deg)), 0, -math.sin(math.radians(azimuth_deg))))
    return out * standoff_m + Vector((0, y_m, 0)), -out


def hit(azimuth_deg, y_m, *blocks):
    origin, direction = line(azimuth_deg, y_m)
    context = bpy.context
    return library("results.picking").cast(
        context.scene, context.view_layer, origin, direction, blocks or None
    )


def pick(first, second, azimuth_deg, y_m, aside_m=0.0):
    """Click a place half way between two blocks on both of them, on the second one a little aside."""
    a, b = hit(azimuth_deg, y_m, first), hit(azimuth_deg, y_m + aside_m, second)
    return bpy.ops.cabletwin.mosaic_pick(block_a=first, point_a=a.point, block_b=second, point_b=b.point)


def pick_ring(*aside_m):
    """A pair for every two neighbours, the partner aside by so much along the cable."""
    for k, aside in enumerate(aside_m or (0.0,) * 4):
        assert pick(NAMES[k], NAMES[(k + 1) % 4], 45 + 90 * k, 0.2, aside) == {"FINISHED"}


def places():
    return {name: np.array(item.matrix_world) for name, item in objects("Block meshes").items()}


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
    assert set(marks) == {"1 · Block1", "1 · Block2"}
    for name, point in (("Block1", pair.point_a), ("Block2", pair.point_b)):
        mark = marks[f"1 · {name}"]
        block = objects("Block meshes")[name]
        np.testing.assert_allclose(mark.location, block.matrix_world @ point, atol=1e-6)


def test_one_block_twice_is_refused(state):
    with pytest.raises(RuntimeError, match="both points are on Block1; pick the partner on another block"):
        pick("Block1", "Block1", 10, 0.2)
    assert len(state.mosaic.pairs) == 0


def test_the_fit_moves_the_blocks_to_where_the_library_puts_them(state):
    pick_ring(0.001, -0.001, 0.001, -0.001)
    before = places()
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}
    joining, pairs = library("pipeline.joining"), library("hand_pairs").gather_pairs(state.mosaic, NAMES)
    joined = joining.join_run(library("opened").opened(bpy.context.scene), pairs)
    for number, name in enumerate(NAMES):
        np.testing.assert_allclose(places()[name], joined.cable_from_block[number], atol=2e-6)
    assert max(np.abs(places()[n] - before[n]).max() for n in NAMES) > 1e-4
    residuals = [p.residual_mm for p in state.mosaic.pairs]
    np.testing.assert_allclose(residuals, np.linalg.norm(joined.residuals_mm, axis=1), atol=1e-6)
    assert max(residuals) < 0.01
    joins = {frozenset((j.block_a, j.block_b)): j for j in state.mosaic.joins}
    assert set(joins) == {frozenset((NAMES[k], NAMES[(k + 1) % 4])) for k in range(4)}
    assert {j.pairs for j in joins.values()} == {1}
    # cameras and clouds stay with their blocks
    cloud = objects("Sparse points")["Block3"]
    np.testing.assert_allclose(np.array(cloud.matrix_world), places()["Block3"], atol=1e-5)


def test_marks_that_contradict_each_other_around_the_ring_show_what_is_left(state):
    pick_ring(0.001, 0.001, 0.001, 0.001)
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}
    assert sum(p.residual_mm for p in state.mosaic.pairs) == pytest.approx(4, abs=0.3)


def test_without_pairs_the_fit_is_refused_in_the_pipelines_words(state):
    state.mosaic.way = "BY_HAND"
    for run in (bpy.ops.cabletwin.mosaic_fit, bpy.ops.cabletwin.mosaic_apply):
        with pytest.raises(RuntimeError, match="there are no pairs; pick one for each two neighbours"):
            run()


def test_a_point_off_its_block_is_refused_in_the_pipelines_words(state):
    pick("Block1", "Block2", 45, 0.2)
    state.mosaic.pairs[0].point_a = (0.2, 0.2, 0.2)
    with pytest.raises(RuntimeError, match=r"of Block1 in pairs.csv lies \d+ mm off its surface"):
        bpy.ops.cabletwin.mosaic_fit()


def test_the_automatic_fit_is_the_runs_own(state):
    before = places()
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}
    for name in NAMES:
        np.testing.assert_allclose(places()[name], before[name], atol=2e-6)
    assert len(state.mosaic.joins) == 4
    assert min(j.pairs for j in state.mosaic.joins) > 10


def test_closing_adds_a_pair_where_there_is_none_and_keeps_the_others(state):
    pick("Block1", "Block2", 45, 0.2)
    mine = tuple(state.mosaic.pairs[0].point_a)
    assert bpy.ops.cabletwin.mosaic_close() == {"FINISHED"}
    pairs = state.mosaic.pairs
    assert {frozenset((p.block_a, p.block_b)) for p in pairs} == {
        frozenset((NAMES[k], NAMES[(k + 1) % 4])) for k in range(4)
    }
    assert [p.found for p in pairs] == [False, True, True, True]
    assert tuple(pairs[0].point_a) == mine
    assert len(state.mosaic.joins) == 4
    bpy.ops.cabletwin.mosaic_close()
    assert len(pairs) == 4


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
    assert state.mosaic.pairs[0].residual_mm < 0.01 < state.mosaic.pairs[1].residual_mm


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


def test_pairs_and_fit_survive_saving(state, tmp_path):
    pick_ring(0.001, -0.001, 0.001, -0.001)
    bpy.ops.cabletwin.mosaic_fit()
    points = [tuple(p.point_b) for p in state.mosaic.pairs]
    fitted = places()
    state = reloaded(tmp_path / "pairs.blend")
    assert [tuple(p.point_b) for p in state.mosaic.pairs] == points
    assert len(objects("Pairs")) == 8
    bpy.ops.cabletwin.mosaic_fit()
    for name in NAMES:
        np.testing.assert_allclose(places()[name], fitted[name], atol=2e-6)


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


def test_apply_joins_as_the_command_line_does_with_the_same_file(state, copied, tmp_path):
    moved(state, copied, tmp_path)
    pick_ring(0.0005, 0.0005, 0.0005, -0.001)
    bpy.ops.cabletwin.mosaic_fit()
    fitted = places()
    points = [tuple(p.point_a) for p in state.mosaic.pairs]
    assert bpy.ops.cabletwin.mosaic_apply() == {"FINISHED"}
    for name in NAMES:
        np.testing.assert_allclose(places()[name], fitted[name], atol=2e-6)
    with (copied / "pairs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [tuple(float(row[f"{axis}_a"]) for axis in "xyz") for row in rows] == points
    shown = [(s.name, s.diameter_mm) for s in state.results.stations]
    words = ("--pairs", copied / "pairs.csv", "--from", "mosaic", "--events", "none")
    done = pipeline("run", tmp_path / "survey.toml", "--out", copied, *words)
    assert done.code == 0, done.stderr
    bpy.ops.cabletwin.results_open()
    assert [(s.name, s.diameter_mm) for s in state.results.stations] == shown
    assert len(objects("Pairs")) == 8
    bpy.ops.cabletwin.mosaic_clear()
    assert bpy.ops.cabletwin.mosaic_read(filepath=str(copied / "pairs.csv")) == {"FINISHED"}
    assert sorted(tuple(p.point_a) for p in state.mosaic.pairs) == sorted(
        [*points[:3], tuple(float(rows[3][f"{axis}_b"]) for axis in "xyz")]
    )


def test_applied_automatically_no_pairs_are_told(state, copied):
    pick("Block1", "Block2", 45, 0.2)
    state.mosaic.way = "AUTOMATIC"
    assert library("hand_pairs").pairs_words(bpy.context.scene, copied) == []
    assert not (copied / "pairs.csv").exists()
