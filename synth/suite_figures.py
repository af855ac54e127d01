"""The figures of a case from evaluation.json and truth.json, and those of several cases together; pure.

Takes plain JSON values and cases; gives figures.  Leaves out running anything, the targets and the table.
"""

import math
from collections.abc import Iterable
from typing import Any

from synth.suite_records import Case, Figures, Json, StationFigures


def station_figures(evaluation: Json, truth: Json) -> tuple[StationFigures, ...]:
    """Figures of every station of an evaluation.json, with the bare sheath's diameter from truth.json."""
    base_mm = {s["name"]: s.get("base_diameter_mm", s["diameter_mm"]) for s in truth["stations"]}
    found = []
    for s in evaluation["diameters"]["stations"]:
        own = s.get("base_model_mm")
        found.append(
            StationFigures(
                name=s["name"],
                truth_mm=s["truth_mm"],
                difference_mm=s["difference_mm"],
                sigma_mm=s["sigma_mm"],
                base_difference_mm=(s["model_mm"] if own is None else own) - base_mm[s["name"]],
                base_sigma_mm=s["sigma_mm"] if s.get("base_sigma_mm") is None else s["base_sigma_mm"],
            )
        )
    return tuple(found)


def evaluation_figures(evaluation: Json) -> dict[str, Any]:
    """What evaluation.json says beside the stations, by the names of a :class:`Case`."""
    surface, relief = evaluation.get("surface") or {}, evaluation.get("relief") or {}
    bow_mm = (evaluation.get("axis") or {}).get("bow_difference_mm")
    overclaimed = [s["overclaimed_deg"] for s in surface.get("stations", ())]
    return {
        "focal_percent": _largest(abs(lens["focal_percent"]) for lens in evaluation.get("lenses") or ()),
        "height_mm": relief.get("largest_mm"),
        "relief_missed": relief.get("missed"),
        "relief_false": relief.get("false"),
        "bow_mm": None if bow_mm is None else abs(bow_mm),
        "coverage_percent": surface.get("coverage_percent"),
        "overclaimed_deg": _largest(overclaimed),
    }


def has_ribs(truth: Json) -> bool:
    """Whether there are ribs on the true cable, so that its bare sheath is what is asked for."""
    return bool(((truth.get("spec") or {}).get("cable") or {}).get("fillet"))


def figures(cases: Iterable[Case]) -> Figures:
    """Take cases together; failed ones have no stations and say nothing."""
    good = [case for case in cases if case.stations]
    if not good:
        return Figures()
    errors = [error for case in good for error in case.errors_mm]
    sizes = [abs(difference) for difference, _ in errors]
    stations = [station for case in good for station in case.stations]
    rms_mm = math.sqrt(sum(size**2 for size in sizes) / len(sizes))
    sigmas = [sigma for _, sigma in errors if sigma is not None]
    return Figures(
        mae_mm=sum(sizes) / len(sizes),
        largest_mm=max(sizes),
        rms_mm=rms_mm,
        mae_mean_mm=_mean(abs(s.difference_mm) for s in stations),
        mean_diameter_mm=_mean(s.truth_mm for s in stations),
        within_1_sigma=_within(errors, 1.0),
        within_2_sigma=_within(errors, 2.0),
        sigma_over_rms=sum(sigmas) / len(sigmas) / rms_mm if sigmas and rms_mm > 0.0 else None,
        focal_percent=_largest(case.focal_percent for case in good),
        height_mm=_largest(case.height_mm for case in good),
        relief_missed=_sum(case.relief_missed for case in good),
        relief_false=_sum(case.relief_false for case in good),
        bow_mm=_largest(case.bow_mm for case in good),
        coverage_percent=_mean(case.coverage_percent for case in good),
        overclaimed_deg=_largest(case.overclaimed_deg for case in good),
        seconds=_mean(case.seconds for case in good),
        peak_memory_mb=_largest(case.peak_memory_mb for case in good),
        **_against_stock(good),
    )


def _against_stock(good: list[Case]) -> dict[str, float | None]:
    """Means of stock COLMAP's figures, and how many times ours they are where both are known."""
    measured = [case for case in good if (case.stock or {}).get("mae_mm") is not None]
    timed = [case for case in good if (case.stock or {}).get("seconds") is not None and case.seconds]
    stock_mae_mm = _mean((case.stock or {})["mae_mm"] for case in measured)
    stock_seconds = _mean((case.stock or {})["seconds"] for case in timed)
    ours_mm = _mean(abs(difference) for case in measured for difference, _ in case.errors_mm)
    ours_s = _mean(case.seconds for case in timed)
    return {
        "stock_mae_mm": stock_mae_mm,
        "stock_seconds": stock_seconds,
        "times_closer": stock_mae_mm / ours_mm if stock_mae_mm is not None and ours_mm else None,
        "times_faster": stock_seconds / ours_s if stock_seconds is not None and ours_s else None,
    }


def _within(errors: Iterable[tuple[float, float | None]], sigmas: float) -> float:
    inside = [sigma is not None and abs(difference) <= sigmas * sigma for difference, sigma in errors]
    return sum(inside) / len(inside)


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _mean(values: Iterable[float | None]) -> float | None:
    known = _known(values)
    return sum(known) / len(known) if known else None


def _largest(values: Iterable[float | None]) -> float | None:
    return max(_known(values), default=None)


def _sum(values: Iterable[int | None]) -> int | None:
    known = [value for value in values if value is not None]
    return sum(known) if known else None
