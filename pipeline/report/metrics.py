"""The few figures that the report derives: difference from truth, mean absolute error, headline.

Takes stations and truth, gives plain numbers; matches truth to stations by name and leaves out what has no
partner.  Differences are always model minus truth.
"""

import math
from dataclasses import dataclass

from pipeline.report.types import LensEffect, StationResult, TruthStation


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A station against its truth: difference = model - truth, relative_percent = |difference| / truth."""

    name: str
    model_mm: float
    truth_mm: float
    difference_mm: float
    relative_percent: float


def compare_with_truth(
    stations: tuple[StationResult, ...], truth: tuple[TruthStation, ...]
) -> dict[str, Comparison]:
    """Station name to its comparison with truth, for the stations whose truth is known (paper, Table 2)."""
    true_mm = {station.name: station.diameter_mm for station in truth}
    rows = {}
    for station in stations:
        if station.name not in true_mm or not math.isfinite(station.diameter_mm):
            continue
        difference_mm = station.diameter_mm - true_mm[station.name]
        rows[station.name] = Comparison(
            name=station.name,
            model_mm=station.diameter_mm,
            truth_mm=true_mm[station.name],
            difference_mm=difference_mm,
            relative_percent=100 * abs(difference_mm) / true_mm[station.name],
        )
    return rows


def mean_absolute_error_mm(rows: dict[str, Comparison]) -> float:
    """Mean of the absolute differences (paper, Table 2, last row); NaN without rows."""
    return mean([abs(row.difference_mm) for row in rows.values()])


def mean(values: list[float]) -> float:
    """Mean of the finite values, NaN where there is none."""
    finite = [value for value in values if math.isfinite(value)]
    return sum(finite) / len(finite) if finite else math.nan


def worst(values: list[float]) -> float:
    """Largest of the finite values, NaN where there is none."""
    return max((value for value in values if math.isfinite(value)), default=math.nan)


def residual_gain(effects: tuple[LensEffect, ...]) -> float:
    """How many times closer the surface fits its cylinder with the lens corrected, over all given blocks."""
    without = mean([effect.residual_uncorrected_mm for effect in effects])
    corrected = mean([effect.residual_corrected_mm for effect in effects])
    return without / corrected if corrected > 0 else math.nan
