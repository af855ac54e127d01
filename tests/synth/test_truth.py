"""truth.json and survey.toml say what the spec implies, in numbers worked out by hand."""

import json
import tomllib

import numpy as np
import pytest

from synth.spec import Cable, Fillet, LensSpec, Robot, Sensor, Spec, Station, SurveyClaim
from synth.truth import survey_toml, truth_of

SPEC = Spec(
    name='stay "7"',
    cable=Cable(
        station=(
            Station(name="A", position_m=0.05, diameter_mm=111.4),
            Station(name="B", position_m=0.15, diameter_mm=110.6),
        ),
        ovality_mm=0.4,
    ),
    robot=Robot(travel_m=0.2, frames=5),
    lens=LensSpec(focal_px=700.0, division_lambda=-0.02),
    survey=SurveyClaim(focal_error_percent=2.0, lambda_given=False, travel_error_percent=-1.0),
)


def test_truth_is_plain_json_with_the_contract_keys():
    truth = json.loads(json.dumps(truth_of(SPEC)))
    assert truth["format"] == 1
    assert set(truth) == {
        *("format", "stations", "radius_mm", "axis", "defects", "poses", "lenses", "travel_m", "spec"),
    }
    assert truth["travel_m"] == 0.2
    assert truth["spec"]["sensor"]["output"] == "video"
    assert truth["lenses"]["Block3"] == {
        "focal_px": 700.0,
        "principal_point_px": [480.0, 300.0],
        "division_lambda": -0.02,
        "lambda_radius": "half-diagonal",
        "width_px": 960,
        "height_px": 600,
    }


def test_stations_carry_the_mean_diameter():
    stations = truth_of(SPEC)["stations"]
    assert [s["name"] for s in stations] == ["A", "B"]
    assert [s["diameter_mm"] for s in stations] == pytest.approx([111.4, 110.6], abs=1e-9)
    ribbed = Spec(
        cable=Cable(diameter_mm=100.0, station=(Station(name="A", position_m=0.1),), fillet=Fillet())
    )
    (station,) = truth_of(ribbed)["stations"]
    assert station["base_diameter_mm"] == pytest.approx(100.0)
    assert station["diameter_mm"] == pytest.approx(100.0 + 2 * 2.0 * 8.0 / (np.pi * 100.0), abs=1e-3)


def test_the_radius_map_has_one_row_of_azimuths_per_position():
    radius = truth_of(SPEC)["radius_mm"]
    values = np.array(radius["values"])
    assert values.shape == (len(radius["position_m"]), len(radius["theta_deg"])) == (101, 180)
    middle = radius["position_m"].index(pytest.approx(0.1))
    east, north = radius["theta_deg"].index(0.0), radius["theta_deg"].index(90.0)
    assert values[middle, east] == pytest.approx(55.5 + 0.1, abs=1e-6)  # mean of both stations, + ovality / 4
    assert values[middle, north] == pytest.approx(55.5 - 0.1, abs=1e-6)


def test_the_pose_of_the_third_frame_at_90_degrees():
    pose = truth_of(SPEC)["poses"]["Block2"][2]
    assert pose["frame"] == 2
    # x_cam = y, y_cam = -x, z_cam = z + 0.3: the camera stands at (0, 0.1, -0.3)
    assert np.array(pose["cam_from_world"]) == pytest.approx(
        np.array([[0, 1, 0, -0.1], [-1, 0, 0, 0], [0, 0, 1, 0.3]]), abs=1e-12
    )


def test_the_survey_claims_what_it_is_told_to_claim():
    survey = tomllib.loads(survey_toml(SPEC))
    assert survey["name"] == 'stay "7"'
    assert survey["cable"]["travel_m"] == pytest.approx(0.198)
    assert survey["cable"]["diameter_mm"] == 111.0
    assert survey["cable"]["station"] == [
        {"name": "A", "position_m": 0.05},
        {"name": "B", "position_m": 0.15},
    ]
    assert survey["robot"] == {"standoff_m": 0.3, "synchronised": True}
    block = survey["block"][3]
    assert (block["name"], block["source"], block["angle_deg"]) == ("Block4", "block4.mp4", 270.0)
    assert block["lens"] == {"focal_px": pytest.approx(714.0), "calibrated": False}


def test_the_survey_states_lambda_and_image_folders_when_asked():
    spec = Spec(sensor=Sensor(output="images"), survey=SurveyClaim(calibrated=True, diameter_given=False))
    survey = tomllib.loads(survey_toml(spec))
    assert "diameter_mm" not in survey["cable"]
    assert survey["block"][0]["source"] == "block1"
    assert survey["block"][0]["lens"] == {
        "focal_px": 720.0,
        "division_lambda": 0.0,
        "lambda_radius": "half-diagonal",
        "calibrated": True,
    }
