"""Targets of a run against the true ones: by name where names agree, else by place.

A target that the run had to name itself, or whose name is another's, is matched to the nearest true one.  A
target that was moved while the survey went on is right at either of its places.
"""

import math

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import most, pairs_by_place, places_of, rms, sigma_check
from pipeline.evaluate.steel.registration_errors import TargetErrors

SAME_M = 0.5
"""A target by this name is the true one of this name if it is no farther from it."""
REACH_M = 0.1
"""A target without a known name belongs to the nearest true one within this."""


def compare_targets(report: Document, truth: Document) -> TargetErrors:
    """Compare all targets that are points; other features have no truth."""
    rows = [row for row in report.items("targets") if row.text("kind") == "point"]
    pairs = _pairs(rows, truth)
    offsets = [row.array("position_m", 3) - place for row, place in pairs]
    sigmas = [row.number_or_nan("sigma_mm") for row, _ in pairs]
    distances = [1000 * float(np.linalg.norm(offset)) for offset in offsets]
    return TargetErrors(
        true=len(list(truth.items("targets"))),
        matched=len(pairs),
        false=len(rows) - len(pairs),
        rms_mm=rms(distances),
        largest_mm=most(distances),
        sigma=sigma_check(
            (1000 * float(value) for offset in offsets for value in offset),
            (sigma for sigma in sigmas for _ in range(3)),
        ),
    )


def matched_places(report: Document, truth: Document) -> tuple[Array, Array]:
    """Found and true places (n, 3) of the targets that both know."""
    rows = [row for row in report.items("targets") if row.text("kind") == "point"]
    pairs = _pairs(rows, truth)
    found = np.array([row.array("position_m", 3) for row, _ in pairs]).reshape(-1, 3)
    return found, np.array([place for _, place in pairs]).reshape(-1, 3)


def _pairs(rows: list[Document], truth: Document) -> list[tuple[Document, Array]]:
    places = {row.text("name"): [row.array("position_m", 3)] for row in truth.items("targets")}
    for row in truth.items("gross"):
        if "moved_to_m" in row and row.text("target") in places:
            places[row.text("target")].append(row.array("moved_to_m", 3))
    pairs, open_rows = [], []
    left = dict(places)
    for row in rows:
        found = row.array("position_m", 3)
        name, near = row.text("name"), _nearest(found, places.get(row.text("name"), []))
        if near is not None and name in left and np.linalg.norm(found - near) < SAME_M:
            pairs.append((row, near))
            del left[name]
        else:
            open_rows.append(row)
    names = [(name, place) for name, choice in left.items() for place in choice]
    by_place = pairs_by_place(
        places_of(open_rows, "position_m"),
        np.array([place for _, place in names]).reshape(-1, 3),
        REACH_M,
    )
    return pairs + [(open_rows[n], names[m][1]) for n, m in by_place.items()]


def _nearest(found: Array, places: list[Array]) -> Array | None:
    return min(places, key=lambda place: math.dist(found, place), default=None)
