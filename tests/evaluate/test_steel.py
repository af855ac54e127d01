"""The steel evaluation finds nothing wrong in a perfect run, and names each spoilt value by its size."""

import json
import math

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.evaluate import evaluate, format_table, write_evaluation
from pipeline.evaluate.steel import evaluate_steel
from tests.evaluate import steel_case
from tests.evaluate.steel_case import case, turned


def found(spoil=None, change=None):
    return evaluate_steel(*case(spoil, change))


def shift(values, by_mm):
    return [value + step / 1000 for value, step in zip(values, by_mm, strict=True)]


def test_a_perfect_run_has_no_errors():
    told = found()
    assert told.stations.largest_mm == pytest.approx(0, abs=1e-9)
    assert told.stations.rms_arcsec == pytest.approx(0, abs=1e-6)
    assert told.stations.fitted_rms_mm == pytest.approx(0, abs=1e-6)
    assert (told.targets.matched, told.targets.false, told.targets.rms_mm) == (8, 0, 0)
    assert (told.gross.named, told.gross.missed, told.gross.false) == ((), (), ())
    assert (told.nodes.eccentric, told.nodes.false, told.nodes.missed) == (2, 0, 0)
    assert (told.columns.right, told.columns.wrong, told.columns.over, told.columns.truly_over) == (
        3,
        0,
        2,
        2,
    )
    assert told.deflection.largest_mm == pytest.approx(0, abs=1e-6)
    assert told.deflection.verdict_right
    assert (told.rods.found, told.rods.doubled, told.rods.false) == (2, 0, 0)
    assert (told.balls.found, told.balls.false) == (15, 0)


def test_a_moved_station_and_a_turned_one_are_told_in_millimetres_and_arc_seconds():
    def spoil(report):
        report["stations"][2]["position_m"] = shift(report["stations"][2]["position_m"], (3, 4, 0))
        report["stations"][3]["rotation"] = (
            np.array(report["stations"][3]["rotation"]) @ turned(20, 0)
        ).tolist()

    told = found(spoil).stations
    assert told.entries[2].distance_mm == pytest.approx(5)
    assert told.entries[3].attitude_arcsec == pytest.approx(20, abs=1e-3)
    # the base, which defines the frame, does not count: 4 stations
    assert told.rms_mm == pytest.approx(5 / 2)
    assert told.rms_arcsec == pytest.approx(20 / 2, abs=1e-3)


def test_sigmas_are_held_against_the_errors():
    def spoil(report):
        for row in report["stations"][1:]:
            row["position_m"] = shift(row["position_m"], (0.5, -0.5, 2.1))

    told = found(spoil).stations.sigma
    assert told.count == 12
    assert told.within_percent == pytest.approx(100 * 8 / 12)
    assert told.over_rms == pytest.approx(1 / math.sqrt((0.25 + 0.25 + 4.41) / 3))


def test_another_datum_is_taken_out_by_the_best_fit_alone():
    turn, step = turned(200, 2), np.array([0.02, -0.01, 0.005])

    def move(values):
        return (turn @ np.array(values) + step).tolist()

    def spoil(report):
        for row in [*report["stations"], *report["targets"]]:
            row["position_m"] = move(row["position_m"])

    told = found(spoil).stations
    assert told.rms_mm > 10
    assert told.fitted_rms_mm == pytest.approx(0, abs=1e-6)
    assert told.fit_rotation_arcsec == pytest.approx(200, abs=1e-3)


def test_chaining_is_judged_by_the_same_truth_and_grows():
    told = found().stations
    assert [row.chained_mm for row in told.entries] == pytest.approx([0, 3, 6, 9, 12])
    assert told.chained_rms_mm == pytest.approx(math.sqrt((9 + 36 + 81 + 144) / 4))
    assert math.isnan(told.icp_rms_mm)


def test_what_turns_the_whole_chain_is_taken_out_by_its_own_fit():
    def spoil(report):
        for n, row in enumerate(report["comparison"]):
            x, y, z = steel_case.place(n)
            row["icp"] = {"position_m": [x, y + 1e-4 * x, z]}

    told = found(spoil).stations
    assert told.icp_rms_mm == pytest.approx(math.sqrt((1 + 4 + 9 + 16) / 4))
    assert told.icp_fitted_rms_mm < 0.05  # half a metre across, turned by 1e-4
    assert told.chained_fitted_rms_mm == pytest.approx(math.sqrt(2) * 3, rel=0.01)  # -6, -3, 0, 3, 6 mm


def test_targets_without_known_names_are_matched_by_place():
    def spoil(report):
        for n, row in enumerate(report["targets"]):
            row["name"] = f"F{n}"
            row["position_m"] = shift(row["position_m"], (0, 0, 2))
        report["targets"].append({"name": "F9", "kind": "point", "position_m": [1, 1, 9], "sigma_mm": 1.0})

    told = found(spoil).targets
    assert (told.matched, told.false) == (8, 1)
    assert told.rms_mm == pytest.approx(2)


def test_a_name_that_the_run_gave_by_itself_and_another_target_has_by_chance_is_not_believed():
    def spoil(report):
        first, second = report["targets"][:2]
        first["name"], second["name"] = second["name"], first["name"]

    told = found(spoil).targets
    assert (told.matched, told.false, told.rms_mm) == (8, 0, 0)


def moved(truth):
    truth["gross"].append(
        {
            "station": "S03", "target": "T05", "kind": "moved", "by_mm": 50.0, "stations": ["S03", "S04"],
            "moved_to_m": shift(truth["targets"][5]["position_m"], (30, 40, 0)),
        }
    )  # fmt: skip


def test_a_moved_target_is_right_at_either_of_its_places():
    def spoil(report):
        report["targets"][5]["position_m"] = shift(report["targets"][5]["position_m"], (30, 40, 1))

    assert found(spoil, moved).targets.largest_mm == pytest.approx(1)


@pytest.mark.parametrize(
    ("station", "target", "kind", "verdict"),
    [
        ("S03", "T05", "moved", (1, 0, 0)),
        ("S01", "T05", "moved", (1, 0, 0)),  # the sights before the move are fewer: they are left out
        ("S03", "T06", "moved", (0, 1, 1)),
        ("S03", "T05", "misnamed", (0, 1, 0)),  # seen, but taken for something else
    ],
)
def test_a_moved_target_is_named_or_missed(station, target, kind, verdict):
    def spoil(report):
        report["gross"].append({"station": station, "target": target, "kind": kind})

    told = found(spoil, moved).gross
    assert (len(told.named), len(told.missed), len(told.false)) == verdict


def test_a_misnamed_target_is_named_under_either_name_by_its_station_alone():
    def change(truth):
        truth["gross"].append(
            {"station": "S02", "target": "T03", "called": "T04", "kind": "misnamed", "by_mm": 9000.0}
        )

    def naming(station, target):
        return lambda report: report["gross"].append(
            {"station": station, "target": target, "kind": "misnamed"}
        )

    assert found(naming("S02", "T04"), change).gross.named == ("misnamed S02 T04",)
    assert found(naming("S02", "T03"), change).gross.named == ("misnamed S02 T04",)
    assert found(naming("S01", "T04"), change).gross.false == ("S01 T04 misnamed",)


def test_eccentricities_are_compared_as_vectors_and_amounts():
    def spoil(report):
        row = report["nodes"][0]
        row["eccentricity_mm"], row["size_mm"] = [6.0, 8.0, 1.0], math.sqrt(101)
        report["nodes"][1]["significant"] = False
        report["nodes"][7]["significant"] = True

    told = found(spoil).nodes
    assert told.largest_mm == pytest.approx(1)
    assert told.amount_largest_mm == pytest.approx(math.sqrt(101) - 10)
    assert (told.missed, told.false) == (1, 1)
    assert told.false_percent == pytest.approx(100 / 13)


def test_nodes_that_were_not_judged_count_as_neither():
    def spoil(report):
        report["nodes"] = report["nodes"][2:]
        report["nodes"][0].update(size_mm=None, eccentricity_mm=[None] * 3)

    told = found(spoil).nodes
    assert (len(told.entries), told.true, told.eccentric, told.missed) == (12, 15, 0, 0)


def test_columns_are_compared_by_component_and_direction():
    def spoil(report):
        report["columns"][2].update(east_mm=4.0, north_mm=-3.0, deviation_mm=5.5)
        report["columns"][0]["over_limit"] = False

    told = found(spoil).columns
    row = told.entries[2]
    assert (row.east_error_mm, row.north_error_mm) == pytest.approx((1, 1))
    assert row.deviation_error_mm == pytest.approx(0.5)
    assert row.direction_error_deg == pytest.approx(
        math.degrees(math.atan2(4, 3) - math.atan2(3, 4)), abs=1e-9
    )
    assert (told.right, told.wrong, told.over) == (2, 1, 1)
    assert told.sigma.within_percent == 100


def test_columns_by_other_names_are_found_by_their_foot_and_missing_ones_told():
    def spoil(report):
        for n, row in enumerate(report["columns"]):
            row["name"] = f"C0{n}"
        report["columns"].pop(1)

    told = found(spoil).columns
    assert [row.name for row in told.entries] == ["8-N", "6-Q"]
    assert told.missing == ("7-P",)


def test_deflection_is_that_below_the_plane_of_the_supports():
    def tilt(truth):
        for row in truth["nodes"]:
            row["ball_m"][2] += 0.01 * row["ball_m"][0] - 0.02 * row["ball_m"][1]

    def spoil(report):
        for row in report["deflection"]["rows"]:
            row["position_m"][2] += 0.01 * row["position_m"][0] - 0.02 * row["position_m"][1]
        report["deflection"]["rows"][7]["deflection_mm"] = 10.5
        report["deflection"]["over_limit"] = True

    told = found(spoil, tilt).deflection
    assert told.true_mm == pytest.approx(9.0, abs=1e-6)
    assert told.largest_mm == pytest.approx(1.5, abs=1e-6)
    assert not told.verdict_right
    assert told.sigma.count == 5


def test_members_are_found_missed_doubled_or_false():
    def spoil(report):
        first = report["members"]["rods"][0]
        half = {**first, "start_m": [1.8, 0.001, 6.0], "end_m": [2.9, 0.001, 6.0], "radius_mm": 30.4}
        elsewhere = {**first, "start_m": [0, 0.2, 6], "end_m": [3, 0.2, 6]}
        across = {**first, "start_m": [1.5, -0.5, 6], "end_m": [1.5, 0.5, 6]}
        report["members"]["rods"] = [first, half, elsewhere, across]

    told = found(spoil).rods
    assert (told.true, told.found, told.doubled, told.false) == (2, 1, 1, 2)
    assert told.place_rms_mm == pytest.approx(math.sqrt((0 + 1) / 2))
    assert told.radius_rms_mm == pytest.approx(math.sqrt((0 + 0.16) / 2))


def test_photos_tell_the_scale_of_their_model():
    centres = [(0.0, 0.0, 20.0), (10.0, 0.0, 20.0), (0.0, 10.0, 20.0), (10.0, 10.0, 21.0)]
    turn = turned(7200, 0)

    def change(truth):
        truth["photos"] = [
            {"name": f"P{n}.jpg", "rotation": turn.tolist(), "translation": (-turn @ np.array(c)).tolist()}
            for n, c in enumerate(centres)
        ]

    def spoil(report):
        places = [[1.002 * value for value in place] for place in centres]
        report["fusion"] = {
            "median_mm": 1.5,
            "photos": [{"name": f"P{n}", "position_m": place} for n, place in enumerate(places)],
        }

    told = found(spoil, change).fusion
    assert told.scale_percent == pytest.approx(0.2)
    assert told.largest_mm == pytest.approx(2 * math.hypot(10, 10, 21))
    assert told.fitted_rms_mm == pytest.approx(0.002 * math.sqrt(50 + 3 / 16) * 1000, rel=0.01)
    assert found(spoil).fusion is None


def test_a_run_of_target_lists_is_judged_by_its_stations():
    def spoil(report):
        report.update(nodes=[], columns=[], deflection=None, members={"rods": [], "balls": [], "columns": []})

    told = found(spoil)
    assert (told.nodes, told.columns, told.deflection, told.rods, told.balls) == (None,) * 5
    assert "RMS 0.000 mm" in format_table(told)


def test_a_station_that_the_truth_does_not_know_is_refused_by_name():
    with pytest.raises(StageError, match=r"station X is not in truth\.json"):
        found(lambda report: report["stations"][0].update(name="X"))


def test_the_command_tells_a_steel_run_from_a_cables(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "report.json").write_text(json.dumps(steel_case.perfect()))
    (tmp_path / "truth.json").write_text(json.dumps(steel_case.truth()))
    told = evaluate(tmp_path / "run", tmp_path / "truth.json")
    text = format_table(told)
    assert "3 judged right, 0 wrong; 2 over the limit, in truth 2" in text
    assert "15 of 15 nodes judged, 2 of them eccentric: 0 missed, 0 false (0.0 %)" in text
    assert "Rods: 2 of 2 found" in text
    write_evaluation(told, tmp_path / "evaluation.json")
    tree = json.loads((tmp_path / "evaluation.json").read_text())
    assert tree["stations"]["entries"][4]["chained_mm"] == pytest.approx(12)
    assert tree["stations"]["icp_rms_mm"] is None


def test_a_steel_run_against_a_cables_truth_is_refused(tmp_path):
    (tmp_path / "report.json").write_text(json.dumps(steel_case.perfect()))
    (tmp_path / "truth.json").write_text(json.dumps({"format": 1, "stations": []}))
    with pytest.raises(StageError, match='kind is not "steel"'):
        evaluate(tmp_path, tmp_path / "truth.json")
