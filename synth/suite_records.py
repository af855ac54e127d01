"""What the suite knows of a case, and what it tells of several.

Records with units in the names, and back from results.json; :mod:`synth.suite_figures` fills them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

Json = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class StationFigures:
    """One station of one case.

    Attributes:
        name: of the station.
        truth_mm: true mean diameter.
        difference_mm, sigma_mm: measured minus true mean diameter, and the standard deviation that the run
            claims for it, None where it claims none.
        base_difference_mm, base_sigma_mm: the same for the bare sheath, without ribs, bulges and dents; a
            run that tells no such diameter is taken at its mean diameter and its sigma.
    """

    name: str
    truth_mm: float
    difference_mm: float
    sigma_mm: float | None
    base_difference_mm: float
    base_sigma_mm: float | None


@dataclass(frozen=True, kw_only=True)
class Case:
    """One scenario with one seed.

    Attributes:
        scenario, seed: which.
        failure: one sentence if a step failed, else None.
        stations: empty after a failure.
        counts_base: the errors that count are those of the bare sheath: there are ribs on the cable.
        focal_percent: largest error of a focal length, in percent, None where the truth has no lens.
        height_mm: largest error of the height of a bulge, dent or rib, None where none was found or asked
            for.
        relief_missed, relief_false: true ones that were missed, finds that are not there; None where not
            told.
        bow_mm: size of the error of the axis' bow, None where the run does not tell it.
        coverage_percent: share of the surface that was measured.
        overclaimed_deg: most coverage that a station tells where the surface is not right.
        seconds: wall-clock time of the pipeline, from videos to report.
        peak_memory_mb: as the pipeline reports it.
        program: digest of the pipeline's modules that made the run, to see which cases go together.
        stock: figures of stock COLMAP on the same frames (mae_mm, seconds, failure), None if not asked for.
    """

    scenario: str
    seed: int
    failure: str | None = None
    stations: tuple[StationFigures, ...] = ()
    counts_base: bool = False
    focal_percent: float | None = None
    height_mm: float | None = None
    relief_missed: int | None = None
    relief_false: int | None = None
    bow_mm: float | None = None
    coverage_percent: float | None = None
    overclaimed_deg: float | None = None
    seconds: float | None = None
    peak_memory_mb: float | None = None
    program: str | None = None
    stock: Json | None = None

    @property
    def errors_mm(self) -> tuple[tuple[float, float | None], ...]:
        """The error that counts of every station, and its sigma."""
        if self.counts_base:
            return tuple((s.base_difference_mm, s.base_sigma_mm) for s in self.stations)
        return tuple((s.difference_mm, s.sigma_mm) for s in self.stations)


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Cases taken together; None where there is nothing to tell.

    Attributes:
        mae_mm, largest_mm, rms_mm: mean, largest and root mean square size of the errors that count.
        mae_mean_mm: mean size of the errors of the mean diameters, which are the same but where there are
            ribs.
        mean_diameter_mm: over the stations, of the truth.
        within_1_sigma, within_2_sigma: share of the stations whose error is at most one, two of their
        sigmas; those
            without sigma count as outside.
        sigma_over_rms: mean sigma over rms_mm.
        focal_percent, height_mm, bow_mm, overclaimed_deg: largest over the cases.
        relief_missed, relief_false: sums.
        coverage_percent, seconds: means; peak_memory_mb: largest.
        stock_mae_mm, stock_seconds: means of stock COLMAP's.
        times_closer, times_faster: stock COLMAP's means over ours of the same cases.
    """

    mae_mm: float | None = None
    largest_mm: float | None = None
    rms_mm: float | None = None
    mae_mean_mm: float | None = None
    mean_diameter_mm: float | None = None
    within_1_sigma: float | None = None
    within_2_sigma: float | None = None
    sigma_over_rms: float | None = None
    focal_percent: float | None = None
    height_mm: float | None = None
    relief_missed: int | None = None
    relief_false: int | None = None
    bow_mm: float | None = None
    coverage_percent: float | None = None
    overclaimed_deg: float | None = None
    seconds: float | None = None
    peak_memory_mb: float | None = None
    stock_mae_mm: float | None = None
    stock_seconds: float | None = None
    times_closer: float | None = None
    times_faster: float | None = None


@dataclass(frozen=True, kw_only=True)
class Results:
    """All cases so far."""

    cases: tuple[Case, ...] = field(default_factory=tuple)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Names of the scenarios, in the order of the cases."""
        return tuple(dict.fromkeys(case.scenario for case in self.cases))

    def of(self, scenario: str) -> tuple[Case, ...]:
        """Cases of one scenario."""
        return tuple(case for case in self.cases if case.scenario == scenario)

    def with_case(self, case: Case) -> "Results":
        """These and another one, which takes the place of an earlier one of the same scenario and seed."""
        others = [old for old in self.cases if (old.scenario, old.seed) != (case.scenario, case.seed)]
        return Results(cases=(*others, case))


def case_from_json(values: Json) -> Case:
    """Build a case again from what :func:`~synth.suite_table.results_json` wrote; other keys are left
    alone."""
    known = {f.name: values[f.name] for f in fields(Case) if f.name in values}
    return Case(**known | {"stations": tuple(StationFigures(**s) for s in known.get("stations", ()))})
