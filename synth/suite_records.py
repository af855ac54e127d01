"""What the suite knows of a case, and the figures drawn from evaluation, report and truth.

Takes the plain JSON values of evaluation.json, report.json and truth.json; gives records with units in the
names.  Leaves out running anything and the table.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

Json = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class StationFigures:
    """One station of one case.

    Attributes:
        name: of the station.
        difference_mm: measured minus true mean diameter.
        base_difference_mm: measured minus true diameter of the bare sheath, without fillets and defects.
        sigma_mm: standard deviation the run claims, None where it claims none.
    """

    name: str
    difference_mm: float
    base_difference_mm: float
    sigma_mm: float | None


@dataclass(frozen=True, kw_only=True)
class Case:
    """One scenario with one seed.

    Attributes:
        scenario, seed: which.
        failure: one sentence if a step failed, else None.
        stations: empty after a failure.
        focal_percent: largest error of a focal length, in percent, None where the truth has no lens.
        coverage_percent: share of the surface that was measured.
        seconds: wall-clock time of the pipeline, from videos to report.
        peak_memory_mb: as the pipeline reports it.
        stock: figures of stock COLMAP on the same frames (mae_mm, seconds, failure), None if not asked for.
    """

    scenario: str
    seed: int
    failure: str | None = None
    stations: tuple[StationFigures, ...] = ()
    focal_percent: float | None = None
    coverage_percent: float | None = None
    seconds: float | None = None
    peak_memory_mb: float | None = None
    stock: Json | None = None


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Stations taken together; None where there is nothing to tell.

    Attributes:
        mae_mm, mae_base_mm: mean absolute error against the mean diameter and against the bare sheath's.
        largest_mm: largest size of an error against the mean diameter.
        rms_mm: root mean square of these errors.
        within_2_sigma: share of the stations whose error is at most two of their sigmas; those without sigma
            count as outside.
        sigma_over_rms: mean sigma over rms_mm.
    """

    mae_mm: float | None = None
    mae_base_mm: float | None = None
    largest_mm: float | None = None
    rms_mm: float | None = None
    within_2_sigma: float | None = None
    sigma_over_rms: float | None = None


@dataclass(frozen=True, kw_only=True)
class Results:
    """All cases so far."""

    cases: tuple[Case, ...] = field(default_factory=tuple)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Names of the scenarios, in the order they were run."""
        return tuple(dict.fromkeys(case.scenario for case in self.cases))

    def of(self, scenario: str) -> tuple[Case, ...]:
        """Cases of one scenario."""
        return tuple(case for case in self.cases if case.scenario == scenario)


def station_figures(evaluation: Json, truth: Json) -> tuple[StationFigures, ...]:
    """Figures of every station of an evaluation.json, with the bare sheath's diameter from truth.json."""
    base_mm = {s["name"]: s.get("base_diameter_mm", s["diameter_mm"]) for s in truth["stations"]}
    return tuple(
        StationFigures(
            name=s["name"],
            difference_mm=s["difference_mm"],
            base_difference_mm=s["model_mm"] - base_mm[s["name"]],
            sigma_mm=s["sigma_mm"],
        )
        for s in evaluation["diameters"]["stations"]
    )


def largest_focal_percent(evaluation: Json) -> float | None:
    """Largest size of a focal length's error over the blocks."""
    return max((abs(lens["focal_percent"]) for lens in evaluation["lenses"] or ()), default=None)


def figures(cases: Iterable[Case]) -> Figures:
    """Take the stations of cases together."""
    stations = [station for case in cases for station in case.stations]
    if not stations:
        return Figures()
    sizes = [abs(s.difference_mm) for s in stations]
    rms_mm = math.sqrt(sum(size**2 for size in sizes) / len(sizes))
    sigmas = [s.sigma_mm for s in stations if s.sigma_mm is not None]
    inside = [s.sigma_mm is not None and abs(s.difference_mm) <= 2.0 * s.sigma_mm for s in stations]
    return Figures(
        mae_mm=sum(sizes) / len(sizes),
        mae_base_mm=sum(abs(s.base_difference_mm) for s in stations) / len(stations),
        largest_mm=max(sizes),
        rms_mm=rms_mm,
        within_2_sigma=sum(inside) / len(inside),
        sigma_over_rms=sum(sigmas) / len(sigmas) / rms_mm if sigmas and rms_mm > 0.0 else None,
    )
