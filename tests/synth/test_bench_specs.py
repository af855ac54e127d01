"""The scenarios of the benchmark: every one is good, says what is hard, and is as hard as the issue asks."""

import json
import tomllib
from pathlib import Path

import pytest

from synth.spec_reader import read_spec
from synth.truth import survey_toml, truth_of

FOLDER = Path(__file__).parents[2] / "specs" / "bench"
NAMES = [path.stem for path in sorted(FOLDER.glob("*.toml"))]


def spec(name):
    return read_spec(FOLDER / f"{name}.toml")


def test_all_scenarios_of_the_issue_are_there():
    assert [
        *("bare", "curved", "defects", "fillet", "lost_camera", "paper", "scale", "size_160", "size_270"),
        *("size_70", "streaks", "strong_lens", "sway", "video"),
    ] == NAMES
    assert len({spec(name).seed for name in NAMES}) == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_is_good_and_its_truth_can_be_computed(name):
    found = spec(name)
    assert found.name == name
    assert (FOLDER / f"{name}.toml").read_text().startswith("# Hard: ")
    assert (len(found.blocks), found.robot.frames) == (4, 24)
    assert (found.lens.width_px, found.lens.height_px) == (960, 600)
    truth = json.loads(json.dumps(truth_of(found), allow_nan=False))
    assert [station["name"] for station in truth["stations"]] == ["A", "B", "C", "D"]
    size_mm = {"size_70": 70, "size_160": 160, "size_270": 270}.get(name, 111)
    assert all(
        station["base_diameter_mm"] == pytest.approx(size_mm, rel=0.005) for station in truth["stations"]
    )


@pytest.mark.parametrize("name", NAMES)
def test_the_cable_fills_the_picture_as_in_the_demo(name):
    found = spec(name)
    share = truth_of(found)["stations"][0]["base_diameter_mm"] / 2000.0 / found.robot.standoff_m
    assert share == pytest.approx(0.185, abs=0.002)


def test_what_is_hard_is_in_truth_or_claim():
    lens = spec("strong_lens").lens
    assert lens.division_lambda == -0.15
    stated = tomllib.loads(survey_toml(spec("strong_lens")))["block"][0]["lens"]
    assert stated["focal_px"] == pytest.approx(756.0)
    assert stated["principal_point_px"] == pytest.approx([487.68, 305.76])
    assert "division_lambda" not in stated
    assert [d["peak_mm"] for d in truth_of(spec("defects"))["defects"]] == [1.5, -1.0]
    rise_mm = [(a["x_mm"] ** 2 + a["z_mm"] ** 2) ** 0.5 for a in truth_of(spec("curved"))["axis"]]
    assert max(rise_mm) == pytest.approx(3.0, abs=1e-3)
    assert len(tomllib.loads(survey_toml(spec("lost_camera")))["block"]) == 3
    assert tomllib.loads(survey_toml(spec("scale")))["cable"]["travel_m"] == pytest.approx(0.46046)
    fillet = truth_of(spec("fillet"))["stations"][0]
    assert fillet["diameter_mm"] - fillet["base_diameter_mm"] == pytest.approx(0.0918, abs=2e-3)


def test_the_defects_keep_clear_of_the_stations_so_that_only_the_surface_tells_them():
    truth = truth_of(spec("defects"))
    for station in truth["stations"]:
        assert station["diameter_mm"] == pytest.approx(station["base_diameter_mm"], abs=1e-6)
