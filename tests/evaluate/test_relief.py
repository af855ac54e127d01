"""Bulges, dents and ribs meet the finds that are theirs."""

from math import radians

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.evaluate import evaluate, format_table
from tests.evaluate.written_run import told

BULGE = {"kind": "bulge", "position_m": 0.145, "azimuth_deg": 20.0, "height_mm": 1.5, "peak_mm": 1.5}
DENT = {"kind": "dent", "position_m": 0.325, "azimuth_deg": 250.0, "height_mm": 1.0, "peak_mm": -1.0}


def find(kind, position_m, azimuth_deg, height_mm):
    return {
        "kind": kind,
        "position_m": position_m,
        "azimuth_deg": azimuth_deg,
        "height_mm": height_mm,
        "sigma_mm": 0.02,
    }


def test_every_defect_meets_the_nearest_find_of_its_kind(case):
    run, truth = case()
    told(truth, defects=[BULGE, DENT])
    finds = [
        find("bulge", 0.150, 25.0, 9.0),
        find("bulge", 0.146, -339.0, 1.55),  # 21 degrees, nearer
        find("dent", 0.145, 20.0, 1.0),  # at the bulge's place, but a dent
        find("dent", 0.325, 265.0, -0.9),  # 14.5 mm around
    ]
    told(run / "report.json", relief=finds)
    found = evaluate(run, truth).relief
    bulge, dent = found.entries
    assert (bulge.found_mm, bulge.difference_mm) == (1.55, pytest.approx(0.05))
    assert bulge.away_mm == pytest.approx(np.hypot(1.0, radians(1.0) * 55.5), abs=0.02)
    assert dent.difference_mm == pytest.approx(-0.1)
    assert dent.away_mm == pytest.approx(14.5, abs=0.1)
    assert (found.missed, found.false) == (0, 2)
    assert found.largest_mm == pytest.approx(0.1)
    assert "missed 0, false 2, ribs 0 of 0" in format_table(evaluate(run, truth))


def test_a_find_too_far_off_is_false_and_the_defect_missed(case):
    run, truth = case()
    told(truth, defects=[BULGE])
    told(run / "report.json", relief=[find("bulge", 0.170, 20.0, 1.5)])
    found = evaluate(run, truth).relief
    assert (found.missed, found.false) == (1, 1)
    assert np.isnan(found.entries[0].difference_mm)
    assert np.isnan(found.largest_mm)
    told(truth, defects=[{"kind": "bulge"}])
    with pytest.raises(StageError, match=r"defects\[0\]\.position_m is missing"):
        evaluate(run, truth)


def test_ribs_are_met_anywhere_along_their_crests(case):
    run, truth = case()
    fillet = {"height_mm": 2.0, "width_mm": 8.0, "pitch_m": 0.6, "angle_deg": 30.0}
    told(truth, defects=[], spec={"cable": {"fillet": fillet}})
    first = find("ridge", 0.3, 30.0 + 180.0 + 0.5, 1.9)  # half a pitch on, half a degree off
    second = find("ridge", 0.15, 30.0 + 180.0 + 90.0, 2.04)
    told(run / "report.json", relief=[first, second])
    found = evaluate(run, truth).relief
    assert [row.difference_mm for row in found.entries] == pytest.approx([-0.1, 0.04])
    slope = 2 * np.pi * 55.5 / 600
    assert found.entries[0].away_mm == pytest.approx(radians(0.5) * 55.5 / np.hypot(1, slope), abs=0.01)
    assert (found.ridges_true, found.ridges_found, found.missed, found.false) == (2, 2, 0, 0)
    told(run / "report.json", relief=[first, find("ridge", 0.15, 30.0, 2.0)])  # 90 degrees from either rib
    found = evaluate(run, truth).relief
    assert (found.ridges_found, found.missed, found.false) == (2, 1, 1)
