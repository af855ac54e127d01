"""Differences, relative errors and the mean absolute error, checked on the paper's own Table 2."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pipeline.report import paper
from pipeline.report.metrics import (
    compare_with_truth,
    mean,
    mean_absolute_error_mm,
    residual_gain,
    worst,
)
from pipeline.report.types import TruthStation
from tests.report import sample


def paper_stations():
    stations = tuple(sample.station(row.name, 0.1, row.model_mm, count=50) for row in paper.TABLE_2)
    truth = tuple(
        TruthStation(name=row.name, position_m=0.1, diameter_mm=row.truth_mm) for row in paper.TABLE_2
    )
    return stations, truth


def test_the_papers_diameters_give_its_errors_but_for_row_a():
    rows = compare_with_truth(*paper_stations())
    for printed in paper.TABLE_2[1:]:
        assert abs(rows[printed.name].difference_mm) == pytest.approx(abs(printed.difference_mm), abs=5e-4)
        assert rows[printed.name].relative_percent == pytest.approx(printed.relative_percent, abs=1e-3)
    assert rows["A"].difference_mm == pytest.approx(0.983, abs=5e-4)
    # Printed with 1.017 for A: 1.0053; with its own row it would be 0.9968.
    assert mean_absolute_error_mm(rows) == pytest.approx(0.99675, abs=5e-4)


def test_a_station_without_truth_is_left_out():
    stations, truth = paper_stations()
    assert set(compare_with_truth(stations, truth[:2])) == {"A", "B"}
    assert math.isnan(mean_absolute_error_mm(compare_with_truth(stations, ())))


def test_unknown_figures_do_not_enter_mean_and_worst():
    assert mean([1.0, math.nan, 3.0]) == 2.0
    assert worst([1.0, math.nan, 3.0]) == 3.0
    assert math.isnan(mean([]))
    assert math.isnan(worst([math.nan]))


def test_the_gain_is_the_ratio_of_the_residuals():
    assert residual_gain((sample.lens_effect(2, 10),)) == pytest.approx(4.812 / 0.093)


def test_a_record_of_the_wrong_shape_is_refused_with_its_name():
    mesh = sample.cylinder_mesh(4, 6)
    with pytest.raises(ValueError, match=r"Mesh\.uv has shape \(3, 2\), wanted \(35, 2\)"):
        replace(mesh, uv=np.zeros((3, 2)))
