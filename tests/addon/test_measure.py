"""Stations, diameters and deviations in Blender are those of the command line."""

import json
import shutil

import bpy
import numpy as np
import pytest

from pipeline.opened import open_run
from pipeline.report.deviation import circle_deviation_mm, profile_at
from tests.command import pipeline

PLACE_M = 0.0973


@pytest.fixture
def scene(rendered, finished):
    """A scene that shows survey and run, which are the session's: not to be changed."""
    return shown(rendered / "survey.toml", finished.folder)


@pytest.fixture
def survey(rendered, tmp_path):
    """The survey in a folder of the test's own."""
    for file in rendered.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path / file.name)
    return tmp_path / "survey.toml"


@pytest.fixture
def own_scene(survey, copied):
    """A scene that shows them, with the run in a folder of the test's own too."""
    return shown(survey, copied)


@pytest.fixture
def run(finished):
    return open_run(finished.folder)


def shown(survey, folder):
    assert bpy.ops.cabletwin.survey_open(filepath=str(survey)) == {"FINISHED"}
    bpy.context.scene.cabletwin.run.folder = str(folder)
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    return bpy.context.scene


def drawn(scene, what):
    """Objects of the stations' collection that carry a custom property, by station."""
    root = next(c for c in scene.collection.children if c.get("cabletwin_kind") == "CableTwin")
    stations = next(c for c in root.children if c["cabletwin_kind"] == "Stations")
    return {o["cabletwin_station"]: o for o in stations.objects if what in o}


def mosaic(scene):
    root = next(c for c in scene.collection.children if c.get("cabletwin_kind") == "CableTwin")
    return next(c for c in root.children if c["cabletwin_kind"] == "Mosaic").objects[0].data


def values(mesh, name, key="value", width=1):
    found = np.empty(width * len(mesh.vertices), dtype=np.float32)
    mesh.attributes[name].data.foreach_get(key, found)
    return found.reshape(-1, width) if width > 1 else found


def test_every_station_is_drawn_with_the_reports_figures(scene, finished):
    labels = drawn(scene, "cabletwin_diameter_mm")
    assert list(labels) == [s["name"] for s in finished.report["stations"]]
    for station in finished.report["stations"]:
        label = labels[station["name"]]
        assert label["cabletwin_diameter_mm"] == station["diameter_mm"]
        assert label["cabletwin_sigma_mm"] == station["sigma_mm"]
        figure = f"{station['diameter_mm']:.3f} ± {station['sigma_mm']:.3f} mm"
        assert label["cabletwin_label"] == f"{station['name']}  {figure}"
        assert label.location.y == pytest.approx(station["position_m"], abs=1e-6)


def test_the_section_is_drawn_at_its_true_place_with_its_deviation_enlarged(scene, run):
    section = run.measurement.sections[0]
    curve = drawn(scene, "cabletwin_deviation_mm")[section.name]
    for factor in (1.0, 40.0):
        scene.cabletwin.measure.factor = factor
        bpy.context.view_layer.update()
        points = np.concatenate(
            [[(curve.matrix_world @ p.co.to_3d())[:] for p in spline.points] for spline in curve.data.splines]
        )
        np.testing.assert_allclose(points[:, 1], section.position_m, atol=1e-6)
        away = np.hypot(*(1000 * points[:, [0, 2]] - section.centre_mm).T) - section.diameter_mm / 2
        measured = np.hypot(*(section.points_mm - section.centre_mm).T) - section.diameter_mm / 2
        assert np.std(away) == pytest.approx(factor * np.std(measured), rel=0.35)


def test_a_station_added_by_position_is_provisional_as_the_profile_says(scene, run):
    count = len(scene.cabletwin.survey.stations)
    assert bpy.ops.cabletwin.measure_station_add(position=PLACE_M) == {"FINISHED"}
    station = scene.cabletwin.survey.stations[count]
    diameter_mm, _ = profile_at(run.measurement, PLACE_M)
    assert station.position == pytest.approx(PLACE_M)
    assert station.provisional_mm == pytest.approx(diameter_mm, abs=1e-3)
    label = drawn(scene, "cabletwin_provisional")[station.name]
    assert label["cabletwin_label"] == f"{station.name}  ≈ {diameter_mm:.1f} mm"
    assert label.location.y == pytest.approx(PLACE_M)


def test_measuring_gives_what_the_command_line_gives_to_the_last_digit(own_scene, survey, copied, tmp_path):
    scene = own_scene
    bpy.ops.cabletwin.measure_station_add(position=PLACE_M)
    joint = (copied / "products" / "all-ring.npz").stat().st_mtime_ns
    assert bpy.ops.cabletwin.measure_run() == {"FINISHED"}
    assert (copied / "products" / "all-ring.npz").stat().st_mtime_ns == joint, "the surface was made again"
    told = json.loads((copied / "report.json").read_text())["stations"]
    assert told[-1]["position_m"] == PLACE_M
    labels = drawn(scene, "cabletwin_diameter_mm")
    assert {n: o["cabletwin_diameter_mm"] for n, o in labels.items()} == {
        s["name"]: s["diameter_mm"] for s in told
    }
    assert drawn(scene, "cabletwin_provisional") == {}
    shown = [(s.name, s.diameter_mm, s.sigma_mm) for s in scene.cabletwin.results.stations]
    assert shown == [
        (s["name"], float(np.float32(s["diameter_mm"])), float(np.float32(s["sigma_mm"]))) for s in told
    ]
    again = shutil.copytree(copied, tmp_path / "again")
    assert pipeline("run", survey, "--out", again, "--from", "measure", "--events", "none").code == 0
    assert json.loads((again / "report.json").read_text())["stations"] == told


def test_a_station_that_is_moved_or_removed_is_no_longer_shown_as_measured(scene):
    survey = scene.cabletwin.survey
    first, second = survey.stations[0].name, survey.stations[1].name
    survey.stations[0].position += 0.004
    assert drawn(scene, "cabletwin_diameter_mm")[first].hide_viewport
    assert first in drawn(scene, "cabletwin_provisional")
    survey.station_index = 1
    assert bpy.ops.cabletwin.measure_station_remove() == {"FINISHED"}
    assert second not in survey.stations
    assert drawn(scene, "cabletwin_diameter_mm")[second].hide_viewport


def test_stations_that_the_survey_left_to_the_pipeline_are_taken_over_first(scene):
    names = [s.name for s in scene.cabletwin.results.stations]
    scene.cabletwin.survey.stations.clear()
    bpy.ops.cabletwin.measure_station_add(position=PLACE_M)
    assert [s.name for s in scene.cabletwin.survey.stations][: len(names)] == names
    assert len(scene.cabletwin.survey.stations) == len(names) + 1


def test_a_place_outside_the_travel_is_refused(scene):
    count = len(scene.cabletwin.survey.stations)
    with pytest.raises(RuntimeError, match="lies outside the travel; choose a place between 0 and"):
        bpy.ops.cabletwin.measure_station_add(position=scene.cabletwin.survey.travel + 0.001)
    assert len(scene.cabletwin.survey.stations) == count


def test_without_a_measured_run_there_is_nothing_to_click_on():
    assert not bpy.ops.cabletwin.measure_station_add.poll()
    assert not bpy.ops.cabletwin.measure_station_show.poll()
    assert not bpy.ops.cabletwin.measure_run.poll()


def test_the_pipelines_refusal_is_told_and_the_scene_stays(scene):
    before = list(drawn(scene, "cabletwin_diameter_mm"))
    scene.cabletwin.survey.stations[0].name = scene.cabletwin.survey.stations[1].name
    with pytest.raises(RuntimeError, match="name"):
        bpy.ops.cabletwin.measure_run()
    assert list(drawn(scene, "cabletwin_diameter_mm")) == before
    assert not bpy.context.window_manager.cabletwin_job.running


def test_the_surface_is_coloured_by_the_librarys_distances_and_back(scene, run):
    mesh, measure = mosaic(scene), scene.cabletwin.measure
    measure.limit_mm = 0.3
    measure.colour_by = "MEAN"
    points = np.array([v.co[:] for v in mesh.vertices])
    wanted = circle_deviation_mm(points, run.measurement, measure.mean_diameter_mm)
    found = values(mesh, "deviation_mm")
    known = np.isfinite(found)
    assert 0.9 < known.mean() <= 1
    np.testing.assert_allclose(found[known], wanted[known], atol=1e-4)
    colours = values(mesh, "Deviation", "color_srgb", 4)
    reddest, bluest = (colours[k] for k in (np.nanargmax(found), np.nanargmin(found)))
    assert reddest[0] > reddest[2]
    assert bluest[2] > bluest[0]
    assert {p.material_index for p in mesh.polygons} == {1}
    measure.colour_by = "TEXTURE"
    assert {p.material_index for p in mesh.polygons} == {0}


def test_another_nominal_diameter_shifts_every_distance(scene):
    mesh, data = mosaic(scene), scene.cabletwin
    data.survey.diameter = (data.measure.mean_diameter_mm + 10) / 1000
    data.measure.limit_mm = 1.0
    data.measure.colour_by = "NOMINAL"
    known = np.isfinite(values(mesh, "deviation_mm"))
    colours = values(mesh, "Deviation", "color_srgb", 4)[known]
    assert (colours[:, 2] > colours[:, 0]).all(), "5 mm inside everywhere"


def test_relief_is_that_of_the_report(scene, finished):
    told = [(f["kind"], f["position_m"], f["height_mm"]) for f in finished.report["relief"]]
    found = [(f.kind, f.position_m, f.height_mm) for f in scene.cabletwin.measure.features]
    assert [f[0] for f in found] == [t[0] for t in told]
    for mine, theirs in zip(found, told, strict=True):
        assert mine[1:] == pytest.approx(theirs[1:], rel=1e-6)
    with pytest.raises(RuntimeError, match="there is no feature 100"):
        bpy.ops.cabletwin.measure_feature_show(index=99)


def test_undo_takes_a_station_back(scene):
    """PyPI's bpy undoes where a person's Blender does: after each operator's push."""
    count = len(scene.cabletwin.survey.stations)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cabletwin.measure_station_add(position=PLACE_M)
    bpy.ops.ed.undo_push(message="added")
    assert len(bpy.context.scene.cabletwin.survey.stations) == count + 1
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert len(scene.cabletwin.survey.stations) == count
    assert drawn(scene, "cabletwin_provisional") == {}


def test_everything_is_there_after_saving_and_loading_without_the_run(own_scene, copied, tmp_path):
    scene = own_scene
    bpy.ops.cabletwin.measure_station_add(position=PLACE_M)
    scene.cabletwin.measure.colour_by = "MEAN"
    labels = {n: o["cabletwin_label"] for n, o in drawn(scene, "cabletwin_label").items()}
    before = values(mosaic(scene), "Deviation", "color_srgb", 4)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    shutil.rmtree(copied)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    scene = bpy.context.scene
    assert {n: o["cabletwin_label"] for n, o in drawn(scene, "cabletwin_label").items()} == labels
    np.testing.assert_array_equal(values(mosaic(scene), "Deviation", "color_srgb", 4), before)
    scene.cabletwin.measure.limit_mm = 0.05
    assert (values(mosaic(scene), "Deviation", "color_srgb", 4) != before).any()
    scene.cabletwin.measure.factor = 100
    bpy.ops.cabletwin.measure_station_add(position=PLACE_M + 0.01)
    assert scene.cabletwin.survey.stations[-1].provisional_mm > 50


def test_two_scenes_show_their_own_stations(scene):
    other = bpy.data.scenes.new("other")
    with bpy.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        other.cabletwin.run.folder = scene.cabletwin.run.folder
        assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    mine, theirs = (drawn(s, "cabletwin_diameter_mm") for s in (scene, other))
    assert list(mine) == list(theirs)
    assert all(
        mine[n] != theirs[n] and mine[n]["cabletwin_label"] == theirs[n]["cabletwin_label"] for n in mine
    )


def test_the_legend_says_the_range_in_numbers(cabletwin, scene):
    overlay = cabletwin.overlay
    assert [text for _, text in overlay.ticks(0.5)] == ["−0.50", "−0.25", "0", "+0.25", "+0.50"]
    assert [text for _, text in overlay.ticks(0.05)][-1] == "+0.050"
    scene.cabletwin.measure.colour_by = "MEAN"
    assert overlay.title(scene).endswith(f"⌀ {scene.cabletwin.measure.mean_diameter_mm:.2f} (mm)")


def test_a_label_moves_out_from_under_the_sidebar_but_what_is_not_seen_gets_none(cabletwin):
    beside = cabletwin.overlay.beside_sidebar
    assert beside(100, 50, 400) == 100
    assert beside(380, 50, 400) == 350
    assert beside(410, 50, 400) == 410


def test_labels_never_lie_over_each_other(cabletwin):
    far, first, second, third = (500, 0, 40, 20), (10, 0, 100, 20), (60, 5, 100, 20), (70, 12, 30, 20)
    assert cabletwin.overlay.apart([far, third, first, second]) == [
        far,
        (70, 44, 30, 20),
        first,
        (60, 22, 100, 20),
    ]
