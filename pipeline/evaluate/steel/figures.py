"""The few formulas of the evaluation: rms, sigma check, rigid fit, angles, matching by place.

Written for it alone, so that the pipeline is not judged by its own hand.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.compared import SigmaCheck

ARCSEC_PER_RADIAN = 180 * 3600 / math.pi


def rms(values: Iterable[float]) -> float:
    """Root mean square of the finite values, NaN without any."""
    known = [value for value in values if math.isfinite(value)]
    return math.sqrt(sum(value * value for value in known) / len(known)) if known else math.nan


def most(values: Iterable[float]) -> float:
    """Largest size of the finite values, NaN without any."""
    return max((abs(value) for value in values if math.isfinite(value)), default=math.nan)


def sigma_check(errors: Iterable[float], sigmas: Iterable[float]) -> SigmaCheck:
    """Errors against the standard deviations claimed for them; those without a sigma are left out."""
    pairs = [(e, s) for e, s in zip(errors, sigmas, strict=True) if math.isfinite(e) and s > 0]
    if not pairs:
        return SigmaCheck(count=0, within_percent=math.nan, over_rms=math.nan)
    within = sum(abs(error) <= 2 * sigma for error, sigma in pairs)
    error_rms = rms(error for error, _ in pairs)
    return SigmaCheck(
        count=len(pairs),
        within_percent=100 * within / len(pairs),
        over_rms=rms(sigma for _, sigma in pairs) / error_rms if error_rms > 0 else math.inf,
    )


def rotation_angle(matrix: Array) -> float:
    """Angle of a rotation, radians: atan2 of its skew part and its trace, exact near zero."""
    skew = (matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1])
    return math.atan2(math.hypot(*skew), float(np.trace(matrix)) - 1)


def rigid_fit(moving: Array, fixed: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and shift (3,) that bring (n, 3) points closest to others: R x + t.

    Horn's quaternion (1987): the eigenvector of the largest eigenvalue of the 4 x 4 matrix of the products.
    """
    a, b = moving - moving.mean(axis=0), fixed - fixed.mean(axis=0)
    s = a.T @ b
    skew = np.array([s[1, 2] - s[2, 1], s[2, 0] - s[0, 2], s[0, 1] - s[1, 0]])
    matrix = np.zeros((4, 4))
    matrix[0, 0] = np.trace(s)
    matrix[0, 1:] = matrix[1:, 0] = skew
    matrix[1:, 1:] = s + s.T - np.trace(s) * np.eye(3)
    w, x, y, z = np.linalg.eigh(matrix)[1][:, -1]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return rotation, fixed.mean(axis=0) - rotation @ moving.mean(axis=0)


def places_of(rows: Iterable[Document], key: str) -> Array:
    """(n, 3) what every row says under ``key``; (0, 3) without any row."""
    return np.array([row.array(key, 3) for row in rows]).reshape(-1, 3)


def pairs_by_place(first: Array, second: Array, reach: float) -> dict[int, int]:
    """Nearest pairs first, each place (n, 3) used once, none farther apart than ``reach``, m."""
    if not len(first) or not len(second):
        return {}
    apart = np.linalg.norm(first[:, None] - second[None], axis=2)
    rows, columns = np.nonzero(apart <= reach)
    order = np.argsort(apart[rows, columns], kind="stable")
    found: dict[int, int] = {}
    taken: set[int] = set()
    for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
        if row not in found and column not in taken:
            found[row] = column
            taken.add(column)
    return found


def triple(values: Sequence[float] | Array) -> tuple[float, float, float]:
    """Three plain numbers."""
    x, y, z = (float(value) for value in values)
    return x, y, z
