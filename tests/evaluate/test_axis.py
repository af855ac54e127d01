"""Bow and course of the axis against truth."""

import numpy as np
import pytest

from pipeline.evaluate import evaluate, format_table
from tests.evaluate.written_run import TRAVEL_M, told


def axis_rows(position_m, x_mm, z_mm):
    return [
        {"position_m": float(y), "x_mm": float(x), "z_mm": float(z)}
        for y, x, z in zip(position_m, x_mm, z_mm, strict=True)
    ]


def test_bow_and_course_of_the_axis_are_compared_less_their_lines(case):
    run, truth = case()
    y = np.linspace(0, TRAVEL_M, 47)
    bend = 4 * (y / TRAVEL_M) * (1 - y / TRAVEL_M)
    told(truth, axis=axis_rows(y, 1.5 * bend, -2.0 * bend))
    crooked = axis_rows(
        y, 1.5 * 1.1 * bend + 0.3 + 2 * y, -2.0 * 1.1 * bend - 5 * y
    )  # tilted, shifted, 10 % more
    crooked[7].update(x_mm=None, z_mm=None)
    told(run / "report.json", axis={"straightness_mm_per_m": 1.0, "profile": crooked})
    found = evaluate(run, truth).axis
    assert found.places == 46
    assert found.length_m == pytest.approx(0.46)
    assert (found.true_bow_mm, found.bow_mm) == (pytest.approx(2.5, abs=2e-3), pytest.approx(2.75, abs=2e-3))
    assert found.bow_difference_mm == pytest.approx(0.25, abs=1e-3)
    # a parabola h 4 s (1 - s) less its best line has the root mean square 2 h / sqrt(45)
    assert found.rms_mm == pytest.approx(0.25 * 2 / 45**0.5, rel=0.07)  # the ends count for more
    assert "diff +0.250 mm" in format_table(evaluate(run, truth))
