"""Pairs picked on the block meshes join the blocks as the command line does with the same file."""

import csv
from dataclasses import replace

import bpy
import numpy as np
import pytest

from tests.addon.picked import NAMES, pick, pick_ring, places
from tests.addon.shown_run import library, moved, objects, opened, reloaded, show
from tests.command import pipeline


@pytest.fixture(scope="module")
def shown(cabletwin, rendered, finished, tmp_path_factory):
    return show(rendered, finished.folder, tmp_path_factory.mktemp("shown"))


@pytest.fixture
def state(shown):
    found = opened(shown)
    bpy.ops.cabletwin.mosaic_show_all()
    return found


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


def adjusted_anew(run):
    """Put the ring's cameras elsewhere by a hundredth of a millimetre, as another adjustment would."""
    store, joint = library("pipeline.core.store"), library("pipeline.cable.joint").RingOrientation
    file = run / "products" / "all-joint.npz"
    found = store.load(joint, file, run)
    first = found.blocks[0]
    poses = replace(first.poses, translations=first.poses.translations + 1e-5)
    store.save(replace(found, blocks=(replace(first, poses=poses), *found.blocks[1:])), file, run)
    (run / "products" / "all-joint.stamp").touch()


def test_pairs_picked_before_a_new_adjustment_are_known_and_refused(state, copied, tmp_path):
    moved(state, copied, tmp_path)
    pick("Block1", "Block2", 45, 0.2)
    pick("Block2", "Block3", 135, 0.2)
    assert library("hand_pairs").outdated(bpy.context.scene) == [False, False]
    adjusted_anew(copied)
    bpy.ops.cabletwin.results_open()
    assert library("hand_pairs").outdated(bpy.context.scene) == [True, False]
    with pytest.raises(RuntimeError, match=r"pair 1 of pairs\.csv was picked on Block1 before it was"):
        bpy.ops.cabletwin.mosaic_fit()
    with pytest.raises(RuntimeError, match=r"pair 1 of .* was picked on Block1 before it was adjusted anew"):
        bpy.ops.cabletwin.mosaic_apply()
    bpy.ops.cabletwin.mosaic_remove(index=0)
    bpy.ops.cabletwin.mosaic_show_all()
    pick("Block1", "Block2", 45, 0.2)
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}


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
    assert [tuple(p.point_a) for p in state.mosaic.pairs] == points


def test_applied_automatically_no_pairs_are_told(state, copied):
    pick("Block1", "Block2", 45, 0.2)
    state.mosaic.way = "AUTOMATIC"
    assert library("hand_pairs").pairs_words(bpy.context.scene, copied) == []
    assert not (copied / "pairs.csv").exists()
