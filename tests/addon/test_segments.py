"""The run of a long survey opens segment by segment, each at its place on the whole cable."""

import json
import math
import shutil

import bpy
import numpy as np
import pytest
from mathutils import Vector

from tests.addon.shown_run import library, named, objects, reloaded, show

START_M = 0.25
"""Where the second segment begins."""
ROLL_DEG = 20.0
"""By which the robot has turned there, in the test that asks."""
ELSEWHERE = {
    "name": "Z",
    "position_m": 0.9,
    "diameter_mm": 108.125,
    "sigma_mm": 0.01,
    "min_mm": 108.0,
    "max_mm": 108.25,
    "coverage_deg": 360.0,
}


@pytest.fixture
def whole(copied):
    """A run of two segments, which are the same run twice."""
    for name in ("001", "002"):
        shutil.copytree(copied / "products", copied / "segments" / name / "products")
        shutil.copy(copied / "options.json", copied / "segments" / name)
    (copied / "products" / "all-mosaic.npz").unlink()
    file = copied / "report.json"
    report = json.loads(file.read_text(encoding="utf-8"))
    report["segments"] = [{"name": "001", "start_m": 0.0}, {"name": "002", "start_m": START_M}]
    report["stations"].append(ELSEWHERE)
    file.write_text(json.dumps(report), encoding="utf-8")
    return copied


@pytest.fixture
def state(rendered, whole, tmp_path):
    show(rendered, whole, tmp_path)
    return bpy.context.scene.cabletwin


def extent_m():
    """Where the cable begins and ends in the view."""
    (cable,) = named("Mosaic").values()
    places = np.empty(3 * len(cable.data.vertices), dtype=np.float32)
    cable.data.vertices.foreach_get("co", places)
    along = places.reshape(-1, 3)[:, 1] + cable.matrix_world.translation.y
    return np.array([along.min(), along.max()])


def test_the_run_shows_its_first_segment_and_says_how_many_there_are(state, whole):
    assert (state.results.segments, state.run.segment) == (2, 1)
    assert state.results.folder == str(whole / "segments" / "001")
    assert state.run.folder == str(whole)


def test_another_segment_lies_at_its_own_place_with_all_that_belongs_to_it(state):
    before, places = (
        extent_m(),
        {n: o.matrix_world.translation.copy() for n, o in named("Block meshes").items()},
    )
    stations = [s.position_m for s in state.results.stations]
    state.run.segment = 2
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    np.testing.assert_allclose(extent_m(), before + START_M, atol=1e-6)
    for name, item in named("Block meshes").items():
        step = item.matrix_world.translation - places[name]
        assert tuple(step) == pytest.approx((0, START_M, 0), abs=1e-6)
    found = [s.position_m for s in state.results.stations]
    assert found[:-1] == pytest.approx([y + START_M for y in stations[:-1]], abs=1e-6)
    assert state.measure.profile[0].position_m > START_M - 0.01


def azimuths_deg():
    """Of the middles of the block meshes."""
    middles = {
        name: item.matrix_world @ (sum((Vector(c) for c in item.bound_box), Vector()) / 8)
        for name, item in objects("Block meshes").items()
    }
    return {name: math.degrees(math.atan2(-m.z, m.x)) for name, m in middles.items()}


def away_mm():
    (cable,) = named("Mosaic").values()
    values = np.empty(len(cable.data.vertices), dtype=np.float32)
    cable.data.attributes["deviation_mm"].data.foreach_get("value", values)
    return values


def test_a_segment_in_which_the_robot_hung_turned_is_turned_with_all_that_belongs_to_it(state, whole):
    """Azimuths grow by the right-hand rule about +y; what was measured turns with what it was measured on."""
    before, away = azimuths_deg(), away_mm()
    file = whole / "report.json"
    report = json.loads(file.read_text(encoding="utf-8"))
    report["segments"][1]["roll_deg"] = ROLL_DEG
    file.write_text(json.dumps(report), encoding="utf-8")
    flat = library("segments").read_run(whole / "segments" / "001")
    turned = library("segments").read_run(whole / "segments" / "002")
    state.run.segment = 2
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    for name, azimuth_deg in azimuths_deg().items():
        assert math.remainder(azimuth_deg - before[name] - ROLL_DEG, 360) == pytest.approx(0, abs=1e-3)
    np.testing.assert_allclose(away_mm(), away, atol=2e-4)
    for one, other in zip(flat.measurement.sections, turned.measurement.sections, strict=True):
        step_deg = azimuth_deg_of(other) - azimuth_deg_of(one) - ROLL_DEG
        np.testing.assert_allclose(np.remainder(step_deg + 180, 360), 180, atol=1e-6)
    for name in ("azimuth", "picture_azimuth"):
        step = getattr(turned.ring, name) - getattr(flat.ring, name)
        np.testing.assert_allclose(step, math.radians(ROLL_DEG))


def azimuth_deg_of(section):
    x, z = section.points_mm.T
    return np.degrees(np.arctan2(-z, x))


def test_stations_of_other_segments_are_told_from_the_whole_report(state):
    (other,) = (s for s in state.results.stations if s.name == "Z")
    assert (other.position_m, other.diameter_mm) == pytest.approx((0.9, 108.125))


def test_a_station_of_another_segment_is_drawn_with_its_own_figures(state):
    station = state.survey.stations.add()
    station.name, station.position = "Z", 0.9
    library("results.stations").refresh_stations(bpy.context.scene)
    drawn = [o for o in named("Stations").values() if o["cabletwin_position_m"] == pytest.approx(0.9)]
    assert [o.get("cabletwin_label") for o in drawn] == ["Z  108.125 ± 0.010 mm"]
    assert not drawn[0].get("cabletwin_provisional")
    station.position = 0.8  # moved: nobody measured there
    library("results.stations").refresh_stations(bpy.context.scene)
    moved = [o for o in named("Stations").values() if o["cabletwin_position_m"] == pytest.approx(0.8)]
    assert [o["cabletwin_label"] for o in moved] == ["Z  –"]


def test_a_segments_folder_opens_that_segment_of_the_whole_run(state, whole):
    assert bpy.ops.cabletwin.results_choose(directory=str(whole / "segments" / "002")) == {"FINISHED"}
    assert (state.run.segment, state.run.folder) == (2, str(whole))
    assert state.results.folder == str(whole / "segments" / "002")


def test_a_number_that_is_too_large_is_the_last_segment(state):
    state.run.segment = 9
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    assert state.run.segment == 2


def test_a_fit_leaves_the_blocks_at_the_segments_place(state):
    state.run.segment = 2
    bpy.ops.cabletwin.results_open()
    before = objects("Block meshes")["Block1"].matrix_world.translation.copy()
    assert bpy.ops.cabletwin.mosaic_fit() == {"FINISHED"}
    step = objects("Block meshes")["Block1"].matrix_world.translation - before
    assert step.length < 0.001


def test_the_choice_survives_save_and_reload(state, tmp_path):
    state.run.segment = 2
    bpy.ops.cabletwin.results_open()
    state = reloaded(tmp_path / "kept.blend")
    assert (state.results.segments, state.run.segment) == (2, 2)
    assert library("opened").opened(bpy.context.scene).folder.name == "002"


def test_a_run_that_was_not_cut_has_no_segments(rendered, copied, tmp_path):
    show(rendered, copied, tmp_path)
    assert bpy.context.scene.cabletwin.results.segments == 0
