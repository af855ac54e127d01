"""An evaluation finds nothing wrong in a perfect run, and tells what does not fit by file and key."""

import json

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.evaluate import evaluate, format_table, write_evaluation
from tests.evaluate.written_run import spoil, true_radius


def test_a_perfect_run_has_no_errors(case):
    found = evaluate(*case())
    for row in (*found.cameras.as_they_stand, *found.cameras.fitted):
        assert row.position_mm < 1e-9
        assert row.attitude_deg < 1e-6
    assert [row.block for row in found.cameras.fitted] == ["Block1", "Block2", "Block3", "Block4", "all"]
    assert [row.frames for row in found.cameras.fitted] == [12, 12, 12, 12, 48]
    assert all(
        abs(row.focal_percent) + abs(row.lambda_error) + row.displacement_px == 0 for row in found.lenses
    )
    assert abs(found.surface.bias_mm) < 2e-3
    assert found.surface.noise_mm < 2e-3
    assert found.surface.wrong_percent == 0
    assert found.surface.coverage_percent == 100
    assert [(s.told_deg, s.right_deg, s.overclaimed_deg) for s in found.surface.stations] == [
        (350, 360, 0)
    ] * 4
    assert (found.axis, found.relief) == (None, None)  # this run is an older one, which tells neither
    assert found.straightness_mm_per_m == 0.12


def test_stations_alone_are_truth_enough(case):
    run, path = case()
    truth = json.loads(path.read_text())
    path.write_text(json.dumps({"format": 1, "stations": truth["stations"]}))
    found = evaluate(run, path)
    assert found.diameters.mean_absolute_mm > 0.9
    assert (found.cameras, found.lenses, found.surface) == (None, None, None)
    assert "MAE 0.9967 mm" in format_table(found)


def test_the_table_shows_each_part_in_aligned_columns(case):
    lines = format_table(evaluate(*case())).splitlines()
    assert lines[1].split()[:9] == ["station", "at", "m", "model", "mm", "truth", "mm", "diff", "mm"]
    row = next(line for line in lines if line.startswith("B "))
    assert row.split() == ["B", "0.200", "112.125", "110.800", "+1.325", "1.196", "0.500", "2.7"]
    assert len({len(line) for line in lines[1:6]}) == 1
    assert "MAE 0.9967 mm, largest 1.325 mm (the paper's MAE: 1.0053 mm)" in lines
    assert sum(line.startswith("Block3") for line in lines) == 3


def test_the_json_holds_every_number_and_null_for_what_is_unknown(case, tmp_path):
    def strip(theta, position):
        radius = true_radius(theta, position)
        radius[:, theta > 120] = np.nan
        return radius

    write_evaluation(evaluate(*case(radius_mm=strip)), tmp_path / "evaluation.json")
    written = json.loads((tmp_path / "evaluation.json").read_text())
    assert written["format"] == 1
    assert written["diameters"]["stations"][1]["difference_mm"] == pytest.approx(1.325)
    assert written["cameras"]["fitted"][-1]["block"] == "all"
    assert written["lenses"][0]["focal_percent"] == 0
    assert written["axis"] is None
    assert written["diameters"]["base_mean_absolute_mm"] is None


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        ("truth", lambda v: v.update(format=2), ["truth.json: format is 2"]),
        ("truth", lambda v: v.pop("stations"), ["stations is missing"]),
        ("truth", lambda v: v.update(stations=[]), ["stations is empty"]),
        ("truth", lambda v: v["stations"][0].pop("diameter_mm"), ["stations[0].diameter_mm is missing"]),
        (
            "truth",
            lambda v: v["stations"][0].update(diameter_mm="big"),
            ["stations[0].diameter_mm is no number"],
        ),
        ("truth", lambda v: v["stations"][0].update(position_m=0.2), ["station A lies at 0.1 m", "at 0.2 m"]),
        ("truth", lambda v: v["stations"][0].update(name="Z"), ["report.json", "station Z"]),
        ("truth", lambda v: v["lenses"].pop("Block3"), ["lenses.Block3 is missing"]),
        ("truth", lambda v: v["poses"]["Block2"].pop(4), ["poses.Block2 has no frame 4"]),
        (
            "truth",
            lambda v: v["poses"]["Block2"][4].update(cam_from_world=[1, 2]),
            ["cam_from_world", "3 x 4"],
        ),
        ("truth", lambda v: v["radius_mm"]["values"].pop(), ["radius_mm.values has the shape"]),
        ("truth", lambda v: v["radius_mm"]["values"][3].__setitem__(5, None), ["radius_mm has gaps"]),
        ("truth", lambda v: v["poses"].pop("Block2"), ["poses.Block2 is missing"]),
        (
            "report",
            lambda v: v["stations"][2].update(diameter_mm=None),
            ["stations[2].diameter_mm is missing"],
        ),
        (
            "report",
            lambda v: v["blocks"][0].update(lambda_radius="corner"),
            ["blocks[0].lambda_radius is corner"],
        ),
    ],
)
def test_files_that_do_not_fit_are_told_with_file_and_key(case, file, change, words):
    run, truth = case()
    spoil(truth if file == "truth" else run / "report.json", change)
    with pytest.raises(StageError) as caught:
        evaluate(run, truth)
    for word in words:
        assert word in str(caught.value)


def test_missing_and_broken_files_are_told(case, tmp_path):
    run, truth = case()
    with pytest.raises(StageError, match="nowhere is no folder"):
        evaluate(tmp_path / "nowhere", truth)
    with pytest.raises(StageError, match=r"none\.json cannot be read"):
        evaluate(run, tmp_path / "none.json")
    (run / "radius_map.npz").write_bytes(b"PK nothing")
    with pytest.raises(StageError, match=r"radius_map\.npz is no map of radii"):
        evaluate(run, truth)
    (run / "radius_map.npz").unlink()
    with pytest.raises(StageError, match=r"radius_map\.npz is missing"):
        evaluate(run, truth)
    (run / "blocks" / "Block1" / "sparse" / "images.bin").write_bytes(b"\1")
    with pytest.raises(StageError, match=r"Block1.sparse cannot be read as a COLMAP model"):
        evaluate(run, truth)
    (run / "report.json").write_text("{")
    with pytest.raises(StageError, match=r"report\.json is no JSON"):
        evaluate(run, truth)
