"""What is opened replaces what was there, outlives its run folder, and is refused whole where it is wrong."""

import json
import shutil

import bpy
import numpy as np
import pytest

from tests.addon.shown_run import reloaded
from tests.addon.steel.scene import cable_run, counts, ends, named, told


def test_opening_again_leaves_nothing_behind(shown):
    before = counts()
    assert bpy.ops.cabletwin.steel_open() == {"FINISHED"}
    assert counts() == before


def test_the_cloud_waits_hidden_behind_the_members_that_it_would_cover(shown, framed):
    def hidden():
        layers = bpy.context.view_layer.layer_collection.children["CableTwin"].children["Steel"].children
        return {layer.name for layer in layers if layer.hide_viewport}

    assert hidden() == {"Cloud"}
    tree = told(framed)
    tree["members"] = {"rods": [], "balls": [], "columns": []}
    tree["columns"] = []
    (framed / "report.json").write_text(json.dumps(tree))
    assert bpy.ops.cabletwin.steel_open() == {"FINISHED"}
    assert hidden() == set()


def test_another_run_takes_the_place_of_the_first(shown, run):
    assert bpy.ops.cabletwin.steel_choose(directory=str(run)) == {"FINISHED"}
    assert not named("Columns")
    assert len(shown.columns) == len(shown.nodes) == 0
    assert shown.sag_limit_mm == -1
    assert len(shown.gross) == 2


def refused(folder, words):
    before = counts()
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.cabletwin.steel_choose(directory=str(folder))
    assert counts() == before


def test_the_run_of_a_cable_is_refused_and_what_is_shown_stays(shown, framed, tmp_path):
    cable_run(tmp_path / "cable")
    refused(tmp_path / "cable", "is the run of a cable.*panel Results")
    (tmp_path / "cable" / "report.json").unlink()
    refused(tmp_path / "cable", "is the run of a cable.*panel Results")
    assert shown.folder == str(framed)


def test_a_steel_run_is_refused_by_the_cables_panel(run):
    with pytest.raises(RuntimeError, match="is the run of a steel structure; open it in the panel Steel"):
        bpy.ops.cabletwin.results_choose(directory=str(run))
    assert not bpy.context.scene.cabletwin.results.folder


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda folder: shutil.rmtree(folder), "is no run folder"),
        (lambda folder: (folder / "report.json").unlink(), "is not finished"),
        (lambda folder: (folder / "report.json").write_text('{"kind": "steel"}'), "damaged or of another"),
        (lambda folder: (folder / "report.json").write_text("{"), "cannot be read"),
        (lambda folder: (folder / "cloud.ply").write_bytes(b"ply\n"), "cloud.ply is damaged"),
        (
            lambda folder: (folder / "cloud.ply").write_bytes((folder / "cloud.ply").read_bytes()[:-1]),
            "cloud.ply is damaged or cut off",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused_with_a_sentence(shown, framed, spoil, words):
    spoil(framed)
    refused(framed, words)
    assert len(named("Columns")) == 4


def test_what_is_shown_survives_save_and_reload_without_the_run(shown, framed, tmp_path):
    shutil.rmtree(framed)
    shown.arrow_scale = 77
    again = reloaded(tmp_path / "shown.blend").steel
    assert (again.folder, again.arrow_scale) == (str(framed), 77)
    assert [node.name for node in again.nodes] == ["N02", "N03", "N01"]
    again.column_index = 1
    assert [item.name for item in bpy.context.selected_objects] == ["A-2"]
    again.arrow_scale = 20
    bpy.context.view_layer.update()
    low, high = ends(named("Arrows")["N02 eccentricity"])
    assert np.linalg.norm(high - low) == pytest.approx(20 * 0.01, rel=1e-4)


def test_undo_takes_an_opened_run_back(framed):
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cabletwin.steel_choose(directory=str(framed))
    bpy.ops.ed.undo_push(message="opened")
    bpy.context.scene.cabletwin.steel.arrow_scale = 200
    bpy.ops.ed.undo_push(message="scaled")
    bpy.ops.ed.undo()
    low, high = ends(named("Arrows")["N02 eccentricity"])
    assert np.linalg.norm(high - low) == pytest.approx(50 * 0.01, rel=1e-4)
    bpy.ops.ed.undo()
    assert not bpy.context.scene.cabletwin.steel.folder
    assert not named("Columns")
