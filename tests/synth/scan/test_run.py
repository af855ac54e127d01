"""A whole synthetic survey on disk: files, formats, truth, and the same bytes for the same seed."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from pipeline.steel.survey import read_steel_survey
from synth.__main__ import main
from synth.scan.run import scan_survey
from synth.scan.spec import CloudFormat, Level, Scanner, ScanSpec, Unit, read_scan_spec

ROOT = Path(__file__).parents[3]
SMALL = read_scan_spec(ROOT / "specs/steel/small.toml")
COARSE = replace(SMALL, scanner=replace(SMALL.scanner, step_deg=2.0, format=CloudFormat.PLY))


def made(spec: ScanSpec, out: Path):
    scanned = scan_survey(spec, out, silent)
    return (
        scanned,
        tomllib.loads((out / "survey.toml").read_text()),
        json.loads((out / "truth.json").read_text()),
    )


def test_the_survey_names_clouds_that_are_there(tmp_path):
    scanned, survey, truth = made(COARSE, tmp_path)
    assert (survey["format"], survey["kind"], survey["name"]) == (1, "steel", "steel-small")
    assert [station["name"] for station in survey["station"]] == ["S01", "S02", "S03", "S04"]
    for station in survey["station"]:
        assert (tmp_path / station["cloud"]).stat().st_size > 1000
        assert "targets" not in station
    assert survey["targets"]["radius_mm"] == 72.5
    assert scanned.rays == 4 * 180 * 71
    assert truth["photos"] == []


def test_truth_is_in_the_base_stations_frame_and_has_all_keys(tmp_path):
    _, survey, truth = made(COARSE, tmp_path)
    assert set(truth) == {
        *("format", "kind", "spec", "north_deg", "plumb", "stations", "targets", "rods", "nodes", "columns"),
        *("deflection", "span_m", "gross", "photos"),
    }
    base = truth["stations"][0]
    assert np.array(base["rotation"]) == pytest.approx(np.eye(3), abs=1e-12)
    assert base["translation"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    (central,) = [node for node in truth["nodes"] if node["name"] == "B2-2"]
    off_mm = 1000.0 * (np.array(central["ball_m"]) - central["rods_m"])
    assert off_mm == pytest.approx(central["eccentricity_mm"], abs=1e-9)
    assert np.linalg.norm(off_mm) == pytest.approx(10.0)
    # 8 east, 6 north, by the north that the survey states
    north = np.radians(survey["structure"]["north_deg"])
    compass = np.array([[np.cos(north), -np.sin(north)], [np.sin(north), np.cos(north)]])
    assert compass @ off_mm[:2] == pytest.approx([8.0, 6.0], abs=1e-3)
    for column, claimed in zip(truth["columns"], survey["column"], strict=True):
        bottom, top = np.array(column["bottom_m"]), np.array(column["top_m"])
        off = top - bottom
        off -= off[2] * np.array(truth["plumb"]) / truth["plumb"][2]
        assert compass @ (1000.0 * off[:2]) == pytest.approx(column["tilt_mm"], abs=1e-3)
        assert column["over_limit"] == (np.linalg.norm(column["tilt_mm"]) > 35.0)
        assert column["height_m"] == pytest.approx(top[2] - bottom[2])
        assert [claimed["bottom_m"], claimed["top_m"]] == pytest.approx([bottom[2], top[2]], abs=1e-4)
        assert np.linalg.norm(np.array(claimed["place_m"]) - (bottom + top)[:2] / 2.0) < 0.1


def test_the_clouds_put_into_the_site_frame_lie_on_the_balls_and_targets(tmp_path):
    exact = Scanner(range_sigma_mm=0.0, angle_sigma_arcsec=0.0, divergence_mrad=0.0, step_deg=0.7)
    spec = replace(COARSE, scanner=replace(exact, format=CloudFormat.PLY))
    _, survey, truth = made(spec, tmp_path)
    from plyfile import PlyData

    spheres = [(np.array(node["ball_m"]), node["radius_mm"]) for node in truth["nodes"]]
    spheres += [(np.array(target["position_m"]), 72.5) for target in truth["targets"]]
    found = np.zeros(len(spheres), int)
    for station, pose in zip(survey["station"], truth["stations"], strict=True):
        vertex = PlyData.read(tmp_path / station["cloud"])["vertex"]
        points = np.column_stack([vertex[name] for name in "xyz"]).astype(float)
        points = points @ np.array(pose["rotation"]).T + pose["translation"]
        for number, (centre, radius_mm) in enumerate(spheres):
            off_mm = 1000.0 * np.linalg.norm(points - centre, axis=1) - radius_mm
            assert off_mm.min() > -radius_mm
            found[number] += np.count_nonzero(np.abs(off_mm) < 0.005)
    assert found.min() > 4


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    spec = replace(COARSE, scanner=replace(COARSE.scanner, format=CloudFormat.LAS))
    for folder, seed in (("a", 11), ("b", 11), ("c", 12)):
        scan_survey(replace(spec, seed=seed), tmp_path / folder, silent)
    names = ["survey.toml", "truth.json", "clouds/S01.las", "clouds/S04.las"]
    for name in names:
        first, again, other = ((tmp_path / folder / name).read_bytes() for folder in "abc")
        assert first == again
        assert first != other


def read_back(path: Path):
    """(n, 4) coordinates as the file has them and intensities."""
    if path.suffix == ".e57":
        import pye57

        with pye57.E57(str(path)) as file:
            data = file.read_scan_raw(0)
        return np.column_stack([data[f"cartesian{axis}"] for axis in "XYZ"] + [data["intensity"]])
    if path.suffix in (".las", ".laz"):
        import laspy

        cloud = laspy.read(path)
        return np.column_stack([cloud.x, cloud.y, cloud.z, np.asarray(cloud.intensity) / 65535.0])
    if path.suffix == ".ply":
        from plyfile import PlyData

        vertex = PlyData.read(path)["vertex"]
        return np.column_stack([vertex[name] for name in ("x", "y", "z", "intensity")])
    rows = np.loadtxt(path, skiprows=1 if path.suffix == ".pts" else 0)
    if path.suffix == ".pts":
        rows[:, 3] = (rows[:, 3] / 2047.0 + 1.0) / 2.0
    return rows


@pytest.mark.parametrize("kind", list(CloudFormat))
@pytest.mark.parametrize("unit", list(Unit))
def test_every_format_holds_the_same_points(tmp_path, kind, unit):
    spec = replace(COARSE, stations=replace(SMALL.stations, count=(1, 1)))
    plain = replace(spec, scanner=replace(COARSE.scanner, step_deg=4.0, format=CloudFormat.XYZ))
    scan_survey(plain, tmp_path / "plain", silent)
    scan_survey(
        replace(plain, scanner=replace(plain.scanner, format=kind, unit=unit)), tmp_path / "other", silent
    )
    expected, rows = (
        read_back(tmp_path / "plain/clouds/S01.xyz"),
        read_back(tmp_path / f"other/clouds/S01.{kind}"),
    )
    scale = 1000.0 if unit == Unit.MILLIMETRE else 1.0
    assert rows[:, :3] / scale == pytest.approx(expected[:, :3], abs=5e-5)
    assert rows[:, 3] == pytest.approx(expected[:, 3], abs=5e-4)
    survey = tomllib.loads((tmp_path / "other/survey.toml").read_text())
    assert survey["station"][0]["unit"] == unit


def test_gross_errors_stand_in_the_truth_and_in_the_lists(tmp_path):
    spec = read_scan_spec(ROOT / "specs/steel/gross.toml")
    _, survey, truth = made(spec, tmp_path)
    moved, misnamed = truth["gross"]
    assert (moved["kind"], moved["target"], moved["station"], moved["by_mm"]) == ("moved", "T15", "S09", 50.0)
    place = next(target["position_m"] for target in truth["targets"] if target["name"] == "T15")
    assert 1000.0 * np.linalg.norm(np.subtract(moved["moved_to_m"], place)) == pytest.approx(50.0)
    assert (misnamed["kind"], misnamed["target"], misnamed["station"]) == ("misnamed", "T05", "S03")
    lines = (tmp_path / survey["station"][2]["targets"]).read_text().splitlines()
    assert lines[0] == "name,x,y,z"
    names = [line.split(",")[0] for line in lines[1:]]
    assert misnamed["called"] in names
    assert "T05" not in names
    assert not (tmp_path / "clouds").exists()


def test_the_command_makes_a_survey_and_tells_its_name(tmp_path, capsys):
    spec = str(ROOT / "specs/steel/hall_12_targets.toml")
    assert main(["scan", spec, str(tmp_path / "out"), "--seed", "3", "--quiet"]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "out/survey.toml")
    assert json.loads((tmp_path / "out/truth.json").read_text())["spec"]["seed"] == 3
    assert main(["scan", str(tmp_path / "none.toml"), str(tmp_path / "out"), "--quiet"]) == 2
    assert "none.toml cannot be read" in capsys.readouterr().err


def test_control_targets_are_stated_within_their_sigma(tmp_path):
    spec = read_scan_spec(ROOT / "specs/steel/hall_12_targets.toml")
    names = tuple(f"T{number:02}" for number in range(1, 26))
    claims = replace(spec.survey, control=names, control_sigma_mm=3.0)
    _, survey, truth = made(replace(spec, survey=claims), tmp_path)
    places = {target["name"]: target["position_m"] for target in truth["targets"]}
    off_mm = 1000.0 * np.array(
        [np.subtract(control["position_m"], places[control["name"]]) for control in survey["control"]]
    )
    assert [control["name"] for control in survey["control"]] == list(names)
    assert 2.4 < off_mm.std() < 3.6  # 75 numbers
    assert {control["sigma_mm"] for control in survey["control"]} == {3.0}
    with pytest.raises(StageError, match=r"survey\.control names T99"):
        scan_survey(replace(spec, survey=replace(spec.survey, control=("T99",))), tmp_path, silent)


def test_the_pipeline_reads_every_survey_that_synth_writes(tmp_path):
    survey = read_steel_survey(made(COARSE, tmp_path / "clouds")[0].survey)
    assert [station.name for station in survey.stations] == ["S01", "S02", "S03", "S04"]
    assert all(station.cloud is not None and station.cloud.exists() for station in survey.stations)
    claims = replace(SMALL.survey, control=("T01", "T02", "T03"), named_sigma=True)
    spec = replace(SMALL, level=Level.TARGETS, survey=claims)
    survey = read_steel_survey(made(spec, tmp_path / "targets")[0].survey)
    assert all(station.targets is not None and station.targets.exists() for station in survey.stations)
    assert [control.name for control in survey.control] == ["T01", "T02", "T03"]
    assert (survey.targets.radius_mm, len(survey.columns)) == (72.5, 4)


def test_an_interrupted_scan_goes_on_and_another_specification_starts_anew(tmp_path):

    def stop_at_the_third(event):
        if event.block == "S03":
            raise Cancelled

    with pytest.raises(Cancelled):
        scan_survey(COARSE, tmp_path / "out", stop_at_the_third)
    assert not (tmp_path / "out/survey.toml").exists()
    assert scan_survey(COARSE, tmp_path / "out", silent).rays == 2 * 180 * 71
    scan_survey(COARSE, tmp_path / "whole", silent)
    for name in ("survey.toml", "truth.json", "clouds/S01.ply", "clouds/S03.ply"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert scan_survey(replace(COARSE, seed=2), tmp_path / "out", silent).rays == 4 * 180 * 71


def test_a_survey_of_somebody_else_is_left_alone(tmp_path):
    (tmp_path / "survey.toml").write_text("mine")
    with pytest.raises(StageError, match="that synth did not write"):
        scan_survey(COARSE, tmp_path, silent)
    assert (tmp_path / "survey.toml").read_text() == "mine"
