"""Bulges, dents and ribs that the run found against those that are there.

Takes report.json's ``relief`` and the truth's ``defects`` and ``spec.cable.fillet``; gives
:class:`ReliefErrors`.  A find belongs to a true one of the same kind within 20 mm on the surface, the
nearest pair first; every other find is false.  Heights are compared by their size, so a dent may be told
negative or positive.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import ReliefError, ReliefErrors

REACH_MM = 20.0
"""A find farther off than this is another one."""

RIDGE = "ridge"


def compare_relief(report: Document, truth: Document) -> ReliefErrors | None:
    """Compare all finds with all true ones; None where run or truth does not tell them (older files).

    Raises:
        StageError: an entry lacks a value.
    """
    if "relief" not in report or "defects" not in truth:
        return None
    radius_mm = _radius_mm(truth)
    true = [*_defects(truth), *_ribs(truth)]
    found = [
        _Place(
            kind=row.text("kind"),
            position_m=row.number("position_m"),
            azimuth_deg=row.number("azimuth_deg"),
            height_mm=abs(row.number("height_mm")),
            sigma_mm=row.number_or_nan("sigma_mm"),
        )
        for row in report.items("relief")
    ]
    away_mm = np.array([[_away_mm(t, f, radius_mm) for f in found] for t in true]).reshape(
        len(true), len(found)
    )
    pairs = _nearest_first(away_mm)
    rows = tuple(_error(t, found[pairs[n]] if n in pairs else None, radius_mm) for n, t in enumerate(true))
    sizes = [abs(row.difference_mm) for row in rows if math.isfinite(row.difference_mm)]
    return ReliefErrors(
        entries=rows,
        ridges_true=sum(place.kind == RIDGE for place in true),
        ridges_found=sum(place.kind == RIDGE for place in found),
        missed=len(true) - len(pairs),
        false=len(found) - len(pairs),
        largest_mm=max(sizes, default=math.nan),
    )


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Something on the surface; a true rib carries its pitch, since it is everywhere along its crest."""

    kind: str
    position_m: float
    azimuth_deg: float
    height_mm: float
    sigma_mm: float = math.nan
    pitch_m: float = math.nan


def _radius_mm(truth: Document) -> float:
    stations = list(truth.items("stations"))
    if not stations:
        raise truth.error("stations is empty")
    return sum(station.number("diameter_mm") for station in stations) / len(stations) / 2


def _defects(truth: Document) -> list[_Place]:
    return [
        _Place(
            kind=row.text("kind"),
            position_m=row.number("position_m"),
            azimuth_deg=row.number("azimuth_deg"),
            height_mm=abs(row.number("peak_mm")),
        )
        for row in truth.items("defects")
    ]


def _ribs(truth: Document) -> list[_Place]:
    """The fillet's two ribs, half a turn apart, each by the point of its crest at y = 0."""
    if "spec" not in truth or "cable" not in truth.inside("spec"):
        return []
    cable = truth.inside("spec").inside("cable")
    if "fillet" not in cable:
        return []
    fillet = cable.inside("fillet")
    return [
        _Place(
            kind=RIDGE,
            position_m=0.0,
            azimuth_deg=fillet.number("angle_deg") + half_turn,
            height_mm=fillet.number("height_mm"),
            pitch_m=fillet.number("pitch_m"),
        )
        for half_turn in (0.0, 180.0)
    ]


def _away_mm(true: _Place, found: _Place, radius_mm: float) -> float:
    """Distance on the surface; to a rib's crest across it, since a point of the crest may lie anywhere along
    it."""
    if true.kind != found.kind:
        return math.inf
    azimuth_deg, along_mm, slope = true.azimuth_deg, 1000 * (found.position_m - true.position_m), 0.0
    if true.kind == RIDGE:
        azimuth_deg += 360 * (found.position_m - true.position_m) / true.pitch_m
        slope, along_mm = 2 * math.pi * radius_mm / (1000 * true.pitch_m), 0.0
    turn_deg = (found.azimuth_deg - azimuth_deg + 180) % 360 - 180
    around_mm = math.radians(turn_deg) * radius_mm / math.hypot(1, slope)
    return math.hypot(around_mm, along_mm)


def _nearest_first(away_mm: Array) -> dict[int, int]:
    """True to found, every one at most once, within reach."""
    pairs: dict[int, int] = {}
    order: Sequence[int] = np.argsort(away_mm, axis=None, kind="stable").tolist()
    for cell in order:
        true, found = divmod(cell, away_mm.shape[1])
        if away_mm[true, found] <= REACH_MM and true not in pairs and found not in pairs.values():
            pairs[true] = found
    return pairs


def _error(true: _Place, found: _Place | None, radius_mm: float) -> ReliefError:
    return ReliefError(
        kind=true.kind,
        position_m=true.position_m if found is None or true.kind != RIDGE else found.position_m,
        azimuth_deg=true.azimuth_deg if found is None or true.kind != RIDGE else found.azimuth_deg,
        truth_mm=true.height_mm,
        found_mm=math.nan if found is None else found.height_mm,
        difference_mm=math.nan if found is None else found.height_mm - true.height_mm,
        sigma_mm=math.nan if found is None else found.sigma_mm,
        away_mm=math.nan if found is None else _away_mm(true, found, radius_mm),
    )
