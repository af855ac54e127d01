"""What the panel *Crop* previews and applies is what the pipeline's own crop decides."""

import math
import tomllib

import bpy
import numpy as np
import pytest

from tests.addon.shown_run import library, moved, objects, opened, reloaded, show
from tests.command import pipeline

CHOSEN = {"incidence": math.radians(50), "least_score": 0.25, "use_start": True, "start": 0.1}
AS_WRITTEN = {"incidence_deg": 50.0, "least_score": 0.25, "from_m": 0.1}


@pytest.fixture(scope="module")
def shown(cabletwin, rendered, finished, tmp_path_factory):
    return show(rendered, finished.folder, tmp_path_factory.mktemp("shown"))


@pytest.fixture
def state(shown):
    return opened(shown)


def choose(crop, **values):
    for key, value in values.items():
        setattr(crop, key, value)


def cut_faces():
    """Number of faces in red, by block."""
    found = {}
    for name, item in objects("Crop preview").items():
        slots = np.empty(len(item.data.polygons), dtype=np.int32)
        item.data.attributes["material_index"].data.foreach_get("value", slots)
        found[name] = int(slots.sum())
    return found


def kept(state, **options):
    """Cells that the pipeline itself keeps, and the faces of its mesh, by block."""
    crop, surface = library("pipeline.cable.crop"), library("pipeline.cable.surface")
    run, survey = (
        library("opened").opened(bpy.context.scene),
        library("gather").gather_survey(bpy.context.scene),
    )
    found = {}
    for block, said in zip(run.blocks, survey.blocks, strict=True):
        keep = crop.crop_block(
            block.name, block.surface, said.angle_deg, survey.robot.standoff_m, crop.CropOptions(**options)
        ).keep
        found[block.name] = (
            keep.mean(),
            len(surface.mesh_surface(block.surface, keep, run.options.surface).faces),
        )
    return found


def test_the_panel_starts_with_the_options_of_the_pipeline(cabletwin):
    gather, crop = library("gather"), library("pipeline.cable.crop")
    assert gather.crop_options(bpy.context.scene) == crop.CropOptions()


def test_the_preview_shows_what_the_pipeline_would_cut_whenever_a_slider_moves(state):
    assert bpy.ops.cabletwin.crop_preview() == {"FINISHED"}
    for options, written in (({}, {}), (CHOSEN, AS_WRITTEN)):
        choose(state.crop, **options)
        expected = kept(state, **written)
        assert {s.name: s.share for s in state.crop.shares} == pytest.approx(
            {name: share for name, (share, _) in expected.items()}
        )
        whole = {name: len(item.data.polygons) for name, item in objects("Crop preview").items()}
        left = {name: whole[name] - cut for name, cut in cut_faces().items()}
        assert left == {name: faces for name, (_, faces) in expected.items()}
        assert 0.2 < min(left[name] / whole[name] for name in left) < 0.97


def test_the_preview_hides_what_lies_over_it_and_shows_it_again(state):
    layers = {layer.name.split(".")[0]: layer for layer in _layers(bpy.context.view_layer.layer_collection)}
    before = {name: layer.hide_viewport for name, layer in layers.items()}
    assert not before["Mosaic"]
    bpy.ops.cabletwin.crop_preview()
    assert layers["Mosaic"].hide_viewport
    bpy.ops.cabletwin.crop_preview()
    assert {name: layer.hide_viewport for name, layer in layers.items()} == before
    assert objects("Crop preview") == {}
    assert not state.crop.previewing


def _layers(layer):
    for child in layer.children:
        yield child
        yield from _layers(child)


def test_options_of_which_nothing_is_left_are_told_in_the_pipelines_words(state):
    bpy.ops.cabletwin.crop_preview()
    state.crop.incidence = math.radians(1.0)
    assert "crop: nothing of Block" in state.crop.message
    assert "lower crop.least_score" in state.crop.message
    state.crop.incidence = math.radians(62.0)
    assert state.crop.message == ""
    state.crop.incidence = math.radians(1.0)
    written = state.survey.written
    with pytest.raises(RuntimeError, match=r"crop: nothing of Block\d is left; raise crop\.incidence_deg"):
        bpy.ops.cabletwin.crop_apply()
    assert state.survey.written == written


def test_reset_goes_back_and_the_preview_follows(state):
    bpy.ops.cabletwin.crop_preview()
    before = cut_faces()
    choose(state.crop, **CHOSEN)
    assert cut_faces() != before
    assert bpy.ops.cabletwin.crop_reset() == {"FINISHED"}
    assert cut_faces() == before


def test_undo_takes_options_and_preview_back_together(state):
    bpy.ops.cabletwin.crop_preview()
    bpy.ops.ed.undo_push(message="preview")
    before = cut_faces()
    choose(state.crop, **CHOSEN)
    bpy.ops.ed.undo_push(message="options")
    bpy.ops.ed.undo()
    state = bpy.context.scene.cabletwin
    assert math.degrees(state.crop.incidence) == pytest.approx(62)
    assert cut_faces() == before


def test_a_preview_survives_saving_and_goes_on(state, tmp_path):
    bpy.ops.cabletwin.crop_preview()
    choose(state.crop, **CHOSEN)
    cut = cut_faces()
    state = reloaded(tmp_path / "preview.blend")
    assert state.crop.previewing
    assert cut_faces() == cut
    assert math.degrees(state.crop.incidence) == pytest.approx(50)
    state.crop.incidence = math.radians(62)
    assert sum(cut_faces().values()) < sum(cut.values())


def test_apply_writes_the_survey_and_gives_what_the_command_line_gives(state, copied, tmp_path):
    moved(state, copied, tmp_path)
    choose(state.crop, **CHOSEN)
    before = (copied / "products" / "Block1-crop.stamp").read_text()
    surface = (copied / "products" / "Block1-surface.npz").stat().st_mtime_ns
    assert bpy.ops.cabletwin.crop_apply() == {"FINISHED"}
    written = tomllib.loads((tmp_path / "survey.toml").read_text())
    assert written["options"]["crop"] == AS_WRITTEN
    assert (copied / "products" / "Block1-crop.stamp").read_text() != before
    assert (copied / "products" / "Block1-surface.npz").stat().st_mtime_ns == surface
    shown = [(s.name, s.diameter_mm) for s in state.results.stations]
    words = ("--from", "crop", "--events", "none")
    done = pipeline("run", tmp_path / "survey.toml", "--out", copied, *words)
    assert done.code == 0, done.stderr
    lines = (copied / "diameters.csv").read_text().splitlines()[1:]
    assert [name for name, _ in shown] == [line.split(",")[0] for line in lines]
    assert (copied / "products" / "Block1-crop.stamp").read_text() != before
    bpy.ops.cabletwin.results_open()
    assert [(s.name, s.diameter_mm) for s in state.results.stations] == shown
    # what the file says is what the panel shows when it is opened again
    bpy.ops.cabletwin.crop_reset()
    bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "survey.toml"))
    assert library("gather").crop_options(bpy.context.scene).from_m == 0.1
    assert math.degrees(state.crop.incidence) == pytest.approx(50)
