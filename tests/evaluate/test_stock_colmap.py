"""Stock COLMAP as the peer: its model gets scale, place and diameters right, and its failures are told."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.survey import survey_from
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Poses
from pipeline.evaluate.documents import read_document
from pipeline.evaluate.stock.place import similarity_from_track
from pipeline.evaluate.stock.records import StepSeconds, StockBlock, StockModel, StockOptions
from pipeline.evaluate.stock_colmap import (
    compare_with_stock_colmap,
    format_stock_table,
    main,
    measure_model,
    summarise,
)
from tests.cable import scene

STATIONS = [("A", 0.06, 111.4), ("B", 0.12, 110.7)]
TURN = Rotation.from_euler("xyz", [20, -70, 130], degrees=True).as_matrix()


def survey_values(sources, angles_deg=(0.0,), direction="right", **lens):
    lens = {"focal_px": scene.FOCAL_PX, "division_lambda": 0.0, "calibrated": True, **lens}
    return {
        "format": 1,
        "name": "test",
        "cable": {"travel_m": scene.TRAVEL_M},
        "robot": {"standoff_m": scene.STANDOFF_M, "synchronised": True},
        "block": [
            {
                "name": f"Block{n}",
                "source": str(source),
                "angle_deg": angle,
                "travel_in_image": direction,
                "lens": lens,
            }
            for n, (source, angle) in enumerate(zip(sources, angles_deg, strict=True), start=1)
        ],
    }


@pytest.fixture
def survey(tmp_path):
    """One camera at 90 degrees; its pictures are not looked at."""
    return survey_from(survey_values([tmp_path], angles_deg=(90.0,)), tmp_path)


def points_of(diameter_mm, azimuth_deg, noise_mm=0.05, count=6000, seed=3):
    """Points of a tapering cable that the camera at the azimuth sees, with noise across the surface."""
    rng = np.random.default_rng(seed)
    azimuth = np.radians(azimuth_deg + rng.uniform(-62, 62, count))
    y = rng.uniform(-0.05, scene.TRAVEL_M + 0.05, count)
    radius = diameter_mm(y) / 2000 + rng.normal(0, noise_mm / 1000, count)
    return radius[:, None] * scene.out_of_cable(azimuth) + y[:, None] * np.array([0, 1, 0])


def tapering(y_m):
    """Even about each station, so that a slab's mean is the station's own diameter."""
    return np.interp(y_m, [0.08, 0.10], [111.4, 110.7])


def as_colmap(poses, points, unit_m=0.07, frames=range(scene.FRAMES)):
    """Poses and points as COLMAP would give them: in a frame and a unit of its own."""
    rows = list(frames)
    shift = np.array([3.0, -1.0, 7.0])
    centres = poses.centres[rows] @ TURN.T / unit_m + shift
    rotations = poses.rotations[rows] @ TURN.T
    return StockModel(
        frames=np.array(rows),
        poses=Poses(rotations=rotations, translations=-np.einsum("nij,nj->ni", rotations, centres)),
        points=points @ TURN.T / unit_m + shift,
        focal_px=scene.FOCAL_PX,
        reprojection_px=0.3,
    )


def measure(model, survey, stations=STATIONS, **options):
    fractions = np.linspace(0, 1, scene.FRAMES)
    return measure_model(model, fractions, survey, survey.blocks[0], stations, StockOptions(**options))


def test_track_and_attitudes_undo_frame_and_unit_of_the_model():
    true = scene.poses(azimuth_deg=90.0)
    scale, rotation, translation = similarity_from_track(as_colmap(true, np.zeros((1, 3))).poses, true)
    assert scale == pytest.approx(0.07, rel=1e-9)
    np.testing.assert_allclose(rotation, TURN.T, atol=1e-9)
    np.testing.assert_allclose(
        rotation @ np.array([3.0, -1.0, 7.0]) * scale + translation, np.zeros(3), atol=1e-9
    )


def test_diameters_come_back_from_a_model_without_scale(survey):
    model = as_colmap(scene.poses(azimuth_deg=90.0), points_of(tapering, 90.0))
    found = measure(model, survey)
    assert found["A"] == pytest.approx(111.4, abs=0.05)
    assert found["B"] == pytest.approx(110.7, abs=0.05)


def test_sway_turns_the_model_but_hardly_changes_a_diameter(survey):
    swaying = scene.poses(azimuth_deg=90.0, sway_deg=0.5, sway_mm=0.5)
    found = measure(as_colmap(swaying, points_of(tapering, 90.0)), survey)
    assert found["A"] == pytest.approx(111.4, abs=0.1)


def test_scale_comes_from_the_frames_that_were_registered(survey):
    model = as_colmap(scene.poses(azimuth_deg=90.0), points_of(tapering, 90.0), frames=range(2, 8))
    assert measure(model, survey)["A"] == pytest.approx(111.4, abs=0.05)


def test_a_travel_one_percent_off_makes_diameters_one_percent_off(survey):
    model = as_colmap(scene.poses(azimuth_deg=90.0), points_of(tapering, 90.0))
    longer = replace(survey, cable=replace(survey.cable, travel_m=1.01 * scene.TRAVEL_M))
    assert measure(model, longer)["B"] / measure(model, survey)["B"] == pytest.approx(1.01, abs=2e-4)


def test_background_and_limb_do_not_pull(survey):
    rng = np.random.default_rng(1)
    surface = points_of(tapering, 90.0)
    far = np.column_stack([rng.normal(0, 1, 300), rng.uniform(0, 0.2, 300), 3 + rng.normal(0, 1, 300)])
    limb = points_of(lambda y: tapering(y) + 6, 90.0 + 75.0, count=700)
    limb = limb[(limb @ scene.out_of_cable(np.radians(90.0))) < 0.055 * np.cos(np.radians(67))]
    found = measure(as_colmap(scene.poses(azimuth_deg=90.0), np.concatenate([surface, far, limb])), survey)
    assert found["A"] == pytest.approx(111.4, abs=0.1)


def test_a_station_without_points_stays_unknown(survey):
    points = points_of(tapering, 90.0)
    points = points[points[:, 1] < 0.09]
    found = measure(as_colmap(scene.poses(azimuth_deg=90.0), points), survey)
    assert found["A"] == pytest.approx(111.4, abs=0.1)
    assert found["B"] is None


def test_one_frame_gives_no_scale(survey):
    model = as_colmap(scene.poses(azimuth_deg=90.0), points_of(tapering, 90.0), frames=[4])
    with pytest.raises(StageError, match="no scale"):
        measure(model, survey)


def block_record(name, diameters, failure=None):
    seconds = StepSeconds(features=1.0, matching=2.0, mapping=3.0, total=6.0, masks=0.5)
    return StockBlock(
        name=name,
        registered=20,
        images=24,
        points=900,
        reprojection_px=0.3,
        focal_px=700.0,
        seconds=seconds,
        diameters=diameters,
        failure=failure,
    )


def test_blocks_are_averaged_before_they_meet_truth():
    blocks = (
        block_record("Block1", {"A": 111.9, "B": 110.5}),
        block_record("Block2", {"A": 111.5, "B": None}, "too few points at B"),
    )
    result = summarise(blocks, STATIONS)
    assert [row.error_mm for row in result.stations] == pytest.approx([0.3, -0.2])
    assert result.mae_mm == pytest.approx(0.25)
    assert result.mae_of_single_blocks_mm == pytest.approx((0.5 + 0.1 + 0.2) / 3)
    assert result.seconds.total == pytest.approx(12.0)
    assert result.failure == "Block2: too few points at B"
    assert "+0.300" in format_stock_table(result)


def test_nothing_measured_is_told_and_not_a_zero():
    result = summarise((block_record("Block1", {"A": None, "B": None}, "COLMAP found no model"),), STATIONS)
    assert result.mae_mm is None
    assert "COLMAP found no model" in format_stock_table(result)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run folder with the painted cable's frames, its survey and its truth."""
    folder = tmp_path_factory.mktemp("stock")
    view = scene.Scene(poses=scene.poses())
    frames = folder / "run" / "blocks" / "Block1" / "frames"
    view.write(frames)
    truth = {"format": 1, "stations": [{"name": "M", "position_m": 0.09, "diameter_mm": 110.0}]}
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")
    (folder / "survey.toml").write_text(
        f"""
format = 1
name = "test"
[cable]
travel_m = {scene.TRAVEL_M}
[robot]
standoff_m = {scene.STANDOFF_M}
synchronised = true
[[block]]
name = "Block1"
source = "run/blocks/Block1/frames"
angle_deg = 0.0
travel_in_image = "right"
lens = {{ focal_px = {scene.FOCAL_PX}, division_lambda = 0.0, calibrated = true }}
""",
        encoding="utf-8",
    )
    return folder


def test_stock_colmap_measures_a_painted_cable(run, capsys):
    out = run / "stock.json"
    status = main(
        [
            str(run / "run"),
            *("--survey", str(run / "survey.toml"), "--truth", str(run / "truth.json"), "--json", str(out)),
        ]
    )
    assert status == 0
    found = json.loads(out.read_text(encoding="utf-8"))
    block = found["per_block"][0]
    assert (block["registered"], block["images"], block["failure"]) == (scene.FRAMES, scene.FRAMES, None)
    assert block["focal_px"] == scene.FOCAL_PX  # calibrated: held
    assert block["diameters"]["M"] == pytest.approx(110.0, abs=1.0)
    assert found["mae_mm"] == pytest.approx(abs(block["diameters"]["M"] - 110.0))
    seconds = found["seconds"]
    assert seconds["total"] == pytest.approx(seconds["features"] + seconds["matching"] + seconds["mapping"])
    assert min(seconds["features"], seconds["matching"], seconds["mapping"]) > 0
    assert f"{scene.FRAMES}/{scene.FRAMES}" in capsys.readouterr().out


def test_pictures_without_texture_fail_as_a_result(tmp_path):
    view = scene.Scene(poses=scene.poses(), texture=lambda azimuth, y_m: np.full(np.shape(y_m), 128.0))
    view.write(tmp_path / "blocks" / "Block1" / "frames")
    survey = survey_from(survey_values([tmp_path]), tmp_path)
    (tmp_path / "truth.json").write_text(
        json.dumps({"format": 1, "stations": [{"name": "A", "position_m": 0.06, "diameter_mm": 110.0}]}),
        encoding="utf-8",
    )
    result = compare_with_stock_colmap(tmp_path, survey, read_document(tmp_path / "truth.json"))
    assert result.mae_mm is None
    assert result.per_block[0].failure == "COLMAP found no model"


def test_an_unknown_block_is_refused(run, capsys):
    inputs = ("--survey", str(run / "survey.toml"), "--truth", str(run / "truth.json"))
    assert main([str(run / "run"), *inputs, "--blocks", "Block9"]) == 2
    assert 'block "Block9" is not in the survey' in capsys.readouterr().err


def test_a_run_without_frames_is_refused(run, tmp_path):
    survey = survey_from(survey_values([run / "truth.json"]), tmp_path)
    with pytest.raises(StageError, match="no frames"):
        compare_with_stock_colmap(tmp_path, survey, read_document(run / "truth.json"))
