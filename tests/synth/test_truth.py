"""truth.json and survey.toml say what the spec implies, in numbers worked out by hand."""

import json
import tomllib

import numpy as np
import pytest

from pipeline.cable.survey import read_survey
from synth.spec import Cable, Defect, Fillet, LensSpec, Robot, Sensor, Spec, Station, SurveyClaim
from synth.truth import source_name, survey_toml, truth_of

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
    assert values.shape == (len(radius["position_m"]), len(radius["theta_deg"])) == (101, 360)
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


def test_truth_tells_the_axis_and_the_peak_of_every_defect():
    bulge = Defect(kind="bulge", height_mm=1.5, position_m=0.1, azimuth_deg=20.0)
    dent = Defect(kind="dent", height_mm=1.0, position_m=0.1, azimuth_deg=200.0, length_mm=60.0)
    truth = truth_of(Spec(cable=Cable(bow_mm=3.0, defect=(bulge, dent)), robot=Robot(travel_m=0.2)))
    middle = truth["axis"][50]
    assert (middle["position_m"], middle["x_mm"]) == (pytest.approx(0.1), pytest.approx(0.0, abs=1e-9))
    assert middle["z_mm"] == pytest.approx(-3.0)  # azimuth 90 degrees is -z
    assert [place["z_mm"] for place in truth["axis"][::100]] == pytest.approx([0.0, 0.0])
    assert [defect["peak_mm"] for defect in truth["defects"]] == [1.5, -1.0]
    assert truth["defects"][1] == {
        "kind": "dent",
        "height_mm": 1.0,
        "position_m": 0.1,
        "azimuth_deg": 200.0,
        "length_mm": 60.0,
        "width_mm": 40.0,
        "peak_mm": -1.0,
    }
    radii_mm = np.array(truth["radius_mm"]["values"])  # about the local axis: the bow is not in them
    assert radii_mm.max() == pytest.approx(55.0 + 1.5, abs=1e-6)
    assert radii_mm[:, 90].max() - radii_mm[:, 90].min() == pytest.approx(0.0, abs=1e-9)


def test_where_two_defects_meet_the_truth_tells_what_they_make_together():
    bulge = Defect(kind="bulge", height_mm=1.5, position_m=0.1, azimuth_deg=20.0)
    dent = Defect(kind="dent", height_mm=1.0, position_m=0.11, azimuth_deg=20.0)  # half-way to the edge
    truth = truth_of(Spec(cable=Cable(defect=(bulge, dent))))
    assert [d["peak_mm"] for d in truth["defects"]] == pytest.approx(
        [1.5 - 0.75**3, -1.0 + 1.5 * 0.75**3], abs=1e-8
    )


def test_a_principal_point_may_be_stated_off_by_a_share_of_the_width():
    claim = SurveyClaim(principal_point_error_percent=1.0)
    block = tomllib.loads(survey_toml(Spec(survey=claim)))["block"][0]
    assert np.subtract(block["lens"]["principal_point_px"], (480.0, 300.0)) == pytest.approx([7.68, 5.76])
    assert truth_of(Spec(survey=claim))["lenses"]["Block1"]["principal_point_px"] == [480.0, 300.0]


def test_the_travel_is_stated_with_a_sigma_only_where_one_is_claimed():
    stated = tomllib.loads(survey_toml(Spec(survey=SurveyClaim(travel_sigma_mm=0.46))))["cable"]
    assert stated["travel_sigma_mm"] == 0.46
    assert "travel_sigma_mm" not in tomllib.loads(survey_toml(Spec()))["cable"]


def test_the_pipeline_reads_the_travel_and_its_sigma_as_they_were_claimed(tmp_path):
    spec = Spec(survey=SurveyClaim(travel_sigma_mm=0.46, travel_error_percent=0.1))
    (tmp_path / "survey.toml").write_text(survey_toml(spec))
    for index in range(len(spec.blocks)):
        (tmp_path / source_name(spec, index)).touch()
    cable = read_survey(tmp_path / "survey.toml").cable
    assert (cable.travel_sigma_mm, cable.travel_m) == (0.46, pytest.approx(1.001 * spec.robot.travel_m))


def test_a_lost_block_is_missing_in_the_survey_only():
    spec = Spec(survey=SurveyClaim(lost_blocks=("Block3",)))
    survey = tomllib.loads(survey_toml(spec))
    assert [block["name"] for block in survey["block"]] == ["Block1", "Block2", "Block4"]
    assert [block["angle_deg"] for block in survey["block"]] == [0.0, 90.0, 270.0]
    assert "Block3" in truth_of(spec)["poses"]
