"""A long survey reconstructed, cropped and joined in Blender, segment by segment; no pairs by hand."""

import shutil
import tomllib

import bpy
import numpy as np
import pytest

from tests.addon.picked import pick
from tests.addon.shown_run import library, named

SEGMENTS = """
[options.segments]
frames = 13
shared = 4
"""
"""Cuts the sixteen frames of the small survey into two."""
ENDS_M = (0.03, 0.22)
"""Between them the surface stays; the segments meet at 0.14 m."""


@pytest.fixture
def state(rendered, tmp_path):
    """The small survey in segments, reconstructed from Blender."""
    for file in rendered.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path / file.name)
    survey = tmp_path / "survey.toml"
    survey.write_text(survey.read_text(encoding="utf-8") + SEGMENTS, encoding="utf-8")
    assert bpy.ops.cabletwin.survey_open(filepath=str(survey)) == {"FINISHED"}
    assert bpy.ops.cabletwin.reconstruct_run() == {"FINISHED"}
    return bpy.context.scene.cabletwin


def extent_m():
    (cable,) = named("Mosaic").values()
    places = np.empty(3 * len(cable.data.vertices), dtype=np.float32)
    cable.data.attributes["position"].data.foreach_get("vector", places)
    along = places.reshape(-1, 3)[:, 1]
    return float(along.min()), float(along.max())


def show_segment(state, number):
    state.run.segment = number
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}


def test_crop_and_mosaic_of_a_run_in_segments(state, tmp_path):
    assert (state.results.segments, state.run.segment) == (2, 1)
    diameters = {s.name: s.diameter_mm for s in state.results.stations}
    assert len(diameters) == 4

    # pairs are of one segment's blocks, and would have the whole survey worked off in one piece
    show_segment(state, 2)
    start_m, end_m = extent_m()
    assert bpy.ops.cabletwin.mosaic_show_all() == {"FINISHED"}
    assert pick("Block1", "Block2", 45, 0.2) == {"FINISHED"}
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}
    refused = "this run was worked off in segments; choose Automatic in the panel Mosaic"
    for apply in (bpy.ops.cabletwin.mosaic_apply, bpy.ops.cabletwin.reconstruct_run):
        with pytest.raises(RuntimeError, match=refused):
            apply()
    assert not (tmp_path / "run" / "pairs.csv").exists()

    # a crop that ends before the shown segment begins
    state.mosaic.way = "AUTOMATIC"
    state.crop.use_end, state.crop.end = True, start_m - 0.02
    refused = r"nothing stays of segment 2, which lies from 0\.\d\d to 0\.\d\d m; show a segment that"
    with pytest.raises(RuntimeError, match=refused):
        bpy.ops.cabletwin.crop_apply()

    # one that cuts both segments, in places of the whole cable
    state.crop.use_start = True
    state.crop.start, state.crop.end = ENDS_M
    assert bpy.ops.cabletwin.crop_preview() == {"FINISHED"}
    shares = {s.name: s.share for s in state.crop.shares}
    assert bpy.ops.cabletwin.crop_apply() == {"FINISHED"}
    assert (state.results.segments, state.run.segment) == (2, 2)
    assert extent_m() == pytest.approx((start_m, ENDS_M[1]), abs=0.002)
    assert end_m > ENDS_M[1] + 0.02
    run = library("opened").opened(bpy.context.scene)
    assert {b.name: b.crop.keep.mean() for b in run.blocks} == pytest.approx(shares)
    show_segment(state, 1)
    assert extent_m()[0] == pytest.approx(ENDS_M[0], abs=0.002)
    kept = {s.name: s.diameter_mm for s in state.results.stations}
    assert {"A", "B", "C"} <= set(kept) <= set(diameters)
    assert all(kept[name] == pytest.approx(diameters[name], abs=0.02) for name in ("A", "B", "C"))

    # joined anew, segment by segment
    assert bpy.ops.cabletwin.mosaic_apply() == {"FINISHED"}
    assert state.results.segments == 2
    assert {s.name: s.diameter_mm for s in state.results.stations} == kept
    written = tomllib.loads((tmp_path / "survey.toml").read_text(encoding="utf-8"))
    assert written["options"]["segments"] == {"frames": 13, "shared": 4}
    assert written["options"]["crop"] == {"from_m": ENDS_M[0], "to_m": ENDS_M[1]}
