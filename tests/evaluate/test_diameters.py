"""Diameters against truth, as the paper's Table 2 tells them, and those of the bare sheath."""

import numpy as np
import pytest

from pipeline.evaluate import evaluate, format_table
from tests.evaluate.written_run import spoil


def test_diameters_repeat_the_papers_table_2(case):
    found = evaluate(*case()).diameters
    assert found.mean_absolute_mm == pytest.approx(0.99675, abs=1e-5)
    a, b, c, d = found.stations
    # the paper prints -1.017 and 0.913 % for A, which contradicts its own diameters
    assert a.difference_mm == pytest.approx(0.983, abs=1e-9)
    assert [round(row.relative_percent, 3) for row in (b, c, d)] == [1.196, 0.947, 0.568]
    assert b.z == pytest.approx(1.325 / 0.5)
    assert found.largest_mm == pytest.approx(1.325)


def test_a_station_without_sigma_has_no_z(case):
    stations = [{"name": n, "position_m": 0.1 * k, "diameter_mm": 111.0} for k, n in enumerate("ABCD", 1)]
    stations[1]["sigma_mm"] = None
    found = evaluate(*case(stations=stations)).diameters.stations
    assert all(np.isnan(row.z) and np.isnan(row.sigma_mm) for row in found)


def test_the_bare_sheath_is_compared_where_both_tell_it(case):
    run, truth = case()
    assert np.isnan(evaluate(run, truth).diameters.base_mean_absolute_mm)

    def bare(values, sigma=None):
        for station in values["stations"]:
            station["base_diameter_mm"] = station["diameter_mm"] - 0.1 - (0.02 if sigma else 0.0)
            station["base_sigma_mm"] = sigma

    spoil(truth, bare)
    spoil(run / "report.json", lambda values: bare(values, 0.03))
    found = evaluate(run, truth).diameters
    assert found.stations[1].base_difference_mm == pytest.approx(1.325 - 0.02)
    assert found.stations[1].base_sigma_mm == 0.03
    assert found.base_mean_absolute_mm == pytest.approx(found.mean_absolute_mm - 0.02)
    assert "MAE of the bare sheath 0.976" in format_table(evaluate(run, truth))
