"""Columns of a run against the true ones: by name where names agree, else by the place of the foot."""

import math

from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import most, pairs_by_place, places_of, rms, sigma_check
from pipeline.evaluate.steel.structure_errors import ColumnError, ColumnErrors

REACH_M = 0.5


def compare_columns(report: Document, truth: Document) -> ColumnErrors:
    """Compare every true column that the run judges."""
    true, found = list(truth.items("columns")), list(report.items("columns"))
    pairs = _pairs(true, found)
    entries = tuple(_entry(true[n], found[m]) for n, m in sorted(pairs.items()))
    components = [v for row in entries for v in (row.north_error_mm, row.east_error_mm)]
    sigmas = [
        found[m].number_or_nan(key)
        for _, m in sorted(pairs.items())
        for key in ("north_sigma_mm", "east_sigma_mm")
    ]
    right = sum(row.over == row.truly_over for row in entries)
    return ColumnErrors(
        entries=entries,
        missing=tuple(row.text("name") for n, row in enumerate(true) if n not in pairs),
        rms_mm=rms(row.deviation_error_mm for row in entries),
        largest_mm=most(row.deviation_error_mm for row in entries),
        component_rms_mm=rms(components),
        component_largest_mm=most(components),
        right=right,
        wrong=len(entries) - right,
        over=sum(row.over for row in entries),
        truly_over=sum(row.values.get("over_limit") is True for row in true),
        sigma=sigma_check(components, sigmas),
    )


def _pairs(true: list[Document], found: list[Document]) -> dict[int, int]:
    names = {row.text("name"): m for m, row in enumerate(found)}
    if any(row.text("name") in names for row in true):
        return {n: names[row.text("name")] for n, row in enumerate(true) if row.text("name") in names}
    flat = [1.0, 1.0, 0.0]
    return pairs_by_place(
        places_of(true, "bottom_m") * flat,
        places_of(found, "bottom_m") * flat,
        REACH_M,
    )


def _entry(true: Document, found: Document) -> ColumnError:
    east_mm, north_mm = true.array("tilt_mm", 2).tolist()
    true_mm = math.hypot(east_mm, north_mm)
    told_east, told_north = found.number("east_mm"), found.number("north_mm")
    turn = math.atan2(told_east, told_north) - math.atan2(east_mm, north_mm)
    return ColumnError(
        name=true.text("name"),
        true_mm=true_mm,
        found_mm=found.number("deviation_mm"),
        deviation_error_mm=found.number("deviation_mm") - true_mm,
        north_error_mm=told_north - north_mm,
        east_error_mm=told_east - east_mm,
        direction_error_deg=math.degrees(abs(math.remainder(turn, 2 * math.pi))),
        sigma_mm=found.number_or_nan("sigma_mm"),
        over=found.values.get("over_limit") is True,
        truly_over=true.values.get("over_limit") is True,
    )
