"""The cable's axis against truth: how far it bows, and how well its course was found.

Takes report.json's ``axis.profile`` and the truth's ``axis``; gives :class:`AxisErrors`.  The run's frame
may lie tilted and shifted to the true one, so the best straight line is taken off both before they are
compared, and a bow is told against the chord, the line through an axis' two ends, which no tilt changes.
"""

from collections.abc import Iterator

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import AxisErrors

LEAST_PLACES = 3
"""A line through two places fits whatever they are."""


def compare_axis(report: Document, truth: Document) -> AxisErrors | None:
    """Compare where both know the axis; None where the run tells none (older runs) or too few places.

    Raises:
        StageError: a profile is none.
    """
    if "axis" not in report or "profile" not in report.inside("axis"):
        return None
    found_y, found = _profile(report.inside("axis").items("profile"))
    true_y, true = _profile(truth.items("axis"))
    if len(true_y) < LEAST_PLACES or len(found_y) < LEAST_PLACES:
        return None
    common = (found_y >= true_y[0] - 1e-9) & (found_y <= true_y[-1] + 1e-9)
    y, found = found_y[common], found[common]
    if len(y) < LEAST_PLACES:
        return None
    true = np.column_stack([np.interp(y, true_y, true[:, column]) for column in (0, 1)])
    away = np.linalg.norm(_off_line(y, found) - _off_line(y, true), axis=1)
    bow_mm, true_bow_mm = _bow_mm(y, found), _bow_mm(y, true)
    return AxisErrors(
        places=len(y),
        length_m=float(y[-1] - y[0]),
        bow_mm=bow_mm,
        true_bow_mm=true_bow_mm,
        bow_difference_mm=bow_mm - true_bow_mm,
        rms_mm=float(np.sqrt(np.mean(away**2))),
        largest_mm=float(away.max()),
    )


def _profile(rows: Iterator[Document]) -> tuple[Array, Array]:
    """(n,) positions in metres, ascending, and (n, 2) x and z in millimetres, places without a centre left
    out."""
    values = [
        [row.number("position_m"), row.number_or_nan("x_mm"), row.number_or_nan("z_mm")] for row in rows
    ]
    profile = np.array(values, dtype=np.float64).reshape(-1, 3)
    profile = profile[np.isfinite(profile).all(axis=1)]
    profile = profile[np.argsort(profile[:, 0])]
    return profile[:, 0], profile[:, 1:]


def _off_line(y: Array, axis_mm: Array) -> Array:
    """The axis less its best straight line."""
    design = np.column_stack([np.ones_like(y), y])
    line, *_ = np.linalg.lstsq(design, axis_mm, rcond=None)
    return np.asarray(axis_mm - design @ line, dtype=np.float64)


def _bow_mm(y: Array, axis_mm: Array) -> float:
    part = ((y - y[0]) / (y[-1] - y[0]))[:, None]
    chord = axis_mm[0] * (1 - part) + axis_mm[-1] * part
    return float(np.linalg.norm(axis_mm - chord, axis=1).max())
