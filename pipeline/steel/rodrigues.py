"""Rigid motion between two stations from common points by the Rodrigues matrix, paper equations (1) to (4).

Takes points in both frames; gives rotation and translation.  Leaves out weights and gross errors: these are
initial values (``register.py`` adjusts).  The paper's (a, b, c) are the vector s here, up to signs.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array

_HALF_TURNS = (np.eye(3), np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1]))
"""Any rotation is within 120 degrees of one of these; s is infinite at 180."""
_ITERATIONS = 50

LEAST_WIDTH_SIGMAS = 5.0
"""Common points nearer to a line than this many sigmas do not hold a turn about it."""
LEAST_WIDTH = 0.01
"""The same as a part of their extent."""


def rodrigues_matrix(s: Array) -> Array:
    """Rotation (3, 3) by 2 atan |s| about s (3,), the matrix below equation (3): (I - [s]x)^-1 (I + [s]x)."""
    square = float(s @ s)
    return ((1 - square) * np.eye(3) + 2 * np.outer(s, s) + 2 * cross_matrix(s)) / (1 + square)


def rodrigues_motion(source: Array, target: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and translation (3,) with target = rotation source + translation, for (n, 3) points.

    Equation (3) multiplies the condition target = R source by (I - [s]x), which makes it linear, and exact
    without noise, but weighs the points by 1 + s^2; repeating it on the turned points until s vanishes makes
    the result the least-squares one.

    Raises:
        StageError: fewer than three points, or points on a line.
    """
    if len(source) < 3:
        raise StageError("register", "a motion needs at least 3 common points", "give more")
    source_centre, target_centre = source.mean(axis=0), target.mean(axis=0)
    x, x0 = source - source_centre, target - target_centre
    if _width(x) <= 1e-9 * np.abs(x).max() or _width(x0) <= 1e-9 * np.abs(x0).max():
        raise StageError("register", "the common points lie on a line", "give one off the line")
    tried: list[tuple[float, int, Array]] = []
    for half_turn in _HALF_TURNS:
        turned = x @ half_turn.T
        if _width(x0 + turned) <= 1e-6 * np.abs(x0).max():
            continue  # half a turn away: the equations are singular
        rotation = rodrigues_matrix(_linear_step(turned, x0)) @ half_turn
        tried.append((float(np.sum((x0 - x @ rotation.T) ** 2)), len(tried), rotation))
    rotation = min(tried)[2]
    for _ in range(_ITERATIONS):
        step = _linear_step(x @ rotation.T, x0)
        rotation = rodrigues_matrix(step) @ rotation
        if step @ step < 1e-24:
            break
    return rotation, target_centre - rotation @ source_centre


def level_motion(source: Array, target: Array) -> tuple[Array, Array]:
    """The same for stations whose z is plumb: a turn about z and a translation, from two points or more.

    Raises:
        StageError: fewer than two points, or points above one another.
    """
    if len(source) < 2:
        raise StageError("register", "a motion needs at least 2 common points", "give more")
    source_centre, target_centre = source.mean(axis=0), target.mean(axis=0)
    x, x0 = source - source_centre, target - target_centre
    sine = float(np.sum(x[:, 0] * x0[:, 1] - x[:, 1] * x0[:, 0]))
    cosine = float(np.sum(x[:, 0] * x0[:, 0] + x[:, 1] * x0[:, 1]))
    length = np.hypot(sine, cosine)
    if length <= 1e-9 * max(float(np.sum(x**2)), 1e-300):
        raise StageError("register", "the common points lie above one another", "give one beside them")
    rotation = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, length]]) / length
    return rotation, target_centre - rotation @ source_centre


def is_wide(points: Array, sigma_m: float) -> bool:
    """Whether (n, 3) points stand far enough off their best line to hold a turn about it."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    off_line = _width(points - points.mean(axis=0)) / np.sqrt(len(points))
    return off_line > max(LEAST_WIDTH_SIGMAS * sigma_m, LEAST_WIDTH * extent)


def consensus(
    source: Array, target: Array, tolerance_m: float, *, level: bool
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The motion that most common points agree on, and which do: rotation, translation, (n,) bool.

    All points first; where they do not agree, every smallest set of them proposes a motion.  The points of a
    misnamed target stay outside.

    Args:
        source, target: (n, 3) common points.
        tolerance_m: how far a point may lie off and still agree.
        level: both z axes are plumb.
    """
    size = 2 if level else 3
    move = level_motion if level else rodrigues_motion
    everything = np.ones(len(source), dtype=bool)
    best: tuple[int, float, NDArray[np.bool_]] | None = None
    proposals = [everything, *(np.isin(np.arange(len(source)), c) for c in _subsets(len(source), size))]
    for chosen in proposals:
        try:
            rotation, translation = move(source[chosen], target[chosen])
        except StageError:
            continue  # these few lie on a line; others may not
        distance = np.linalg.norm(source @ rotation.T + translation - target, axis=1)
        inside = distance < tolerance_m
        if best is None or (inside.sum(), -float(distance[inside].sum())) > best[:2]:
            best = (int(inside.sum()), -float(distance[inside].sum()), inside)
        if inside.all():
            break
    if best is None or best[0] < size:
        return np.eye(3), np.zeros(3), np.zeros(len(source), dtype=bool)
    rotation, translation = move(source[best[2]], target[best[2]])
    return rotation, translation, best[2]


def _subsets(count: int, size: int) -> list[tuple[int, ...]]:
    """Smallest sets of points; of many points only those of a few dozen, evenly spread."""
    most = 16 if size == 3 else 32
    few = np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))
    return list(combinations(few.tolist(), size))


def _linear_step(turned: Array, target: Array) -> Array:
    """Solve the normal equations of (3), target - turned = s x (target + turned), for s."""
    rows = -cross_matrix(target + turned)
    normal = np.einsum("nij,nik->jk", rows, rows)
    solution: Array = np.linalg.solve(normal, np.einsum("nij,ni->j", rows, target - turned))
    return solution


def _width(centred: Array) -> float:
    """Second singular value of (n, 3) centred points: zero on a line."""
    return float(np.linalg.svd(centred, compute_uv=False)[1])
