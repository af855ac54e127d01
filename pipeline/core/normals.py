"""The reduced normal equations of a bundle adjustment.

Takes the observation equations (:class:`~pipeline.core.rig.Linearisation`) and priors; gives the damped
Gauss-Newton step and the covariance of the orientations.  Tie points are eliminated by the Schur complement
(Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, section 6.1), in chunks of neighbouring
points, so that memory follows the overlap of the frames and not the length of the survey.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from pipeline.core.rig import Linearisation, Observations
from pipeline.core.vocabulary import Array

Indices = NDArray[np.int64]
POINTS_PER_CHUNK = 2000


@dataclass(frozen=True)
class Chunk:
    """Points ``first`` to ``last``; for each image a run of its observations and their points, counted from
    ``first``."""

    first: int
    last: int
    images: tuple[tuple[slice, Indices], ...]


@dataclass(frozen=True, kw_only=True)
class PointEquations:
    """Pseudo-observations of the points, one each, with unknowns of their own that all points share.

    Attributes:
        residuals: (M,) observed minus computed, weighted.
        points: (M, 3) derivative of the computed by the point, weighted.
        shared: (M, S) derivative by the shared unknowns, weighted.
        information: (S, S) of the shared unknowns themselves; right: (S,) its right-hand side.
    """

    residuals: Array
    points: Array
    shared: Array
    information: Array
    right: Array


@dataclass(frozen=True)
class _Eliminated:
    """One chunk's part of the normal equations: (u,) unknowns, (u, 3, m) cross terms, (m, 3, 3), (m, 3)."""

    chunk: Chunk
    unknowns: Indices
    cross: Array
    blocks: Array
    right: Array


@dataclass(frozen=True)
class Normals:
    """Normal equations before elimination: (U, U), (U,), the unknowns that are not held, the points'
    parts."""

    matrix: Array
    right: Array
    active: Indices
    parts: tuple[_Eliminated, ...]


def order_along_cable(observations: Observations) -> Indices:
    """(N,) the order of observations that :func:`split_along_cable` cuts into the fewest runs."""
    chunk = observations.point // POINTS_PER_CHUNK
    return np.lexsort((observations.point, _image(observations), chunk))


def split_along_cable(observations: Observations, points: int) -> tuple[Chunk, ...]:
    """Cut the points into chunks of neighbours, and the observations into runs of one chunk and one image."""
    chunk, image = observations.point // POINTS_PER_CHUNK, _image(observations)
    changes = (np.diff(chunk, prepend=-1) != 0) | (np.diff(image, prepend=-1) != 0)
    bounds = [*np.flatnonzero(changes).tolist(), len(observations)]
    firsts = range(0, points, POINTS_PER_CHUNK)
    images: list[list[tuple[slice, Indices]]] = [[] for _ in firsts]
    for start, end in pairwise(bounds):
        number = int(chunk[start])
        images[number].append((slice(start, end), observations.point[start:end] - firsts[number]))
    return tuple(
        Chunk(first, min(first + POINTS_PER_CHUNK, points), tuple(runs))
        for first, runs in zip(firsts, images, strict=True)
    )


def _image(observations: Observations) -> Indices:
    return observations.frame * (observations.camera.max(initial=0) + 1) + observations.camera


def point_equations(state: Linearisation, roots: Array, points: int) -> tuple[Array, Array]:
    """Every point's own normal equations with all else held: (M, 3, 3) and (M, 3).

    Args:
        state: observation equations.
        roots: (N,) square root of each observation's weight, 0 where a point cannot be projected.
        points: M.
    """
    weights = roots**2
    residuals = np.where(roots > 0, state.residuals.T, 0.0)

    def summed(first: Array, second: Array) -> Array:
        shares = weights * (first[0] * second[0] + first[1] * second[1])
        return np.bincount(state.point, weights=shares, minlength=points)

    blocks = np.empty((points, 3, 3))
    for i in range(3):
        for j in range(i + 1):
            blocks[:, i, j] = blocks[:, j, i] = summed(state.points[i], state.points[j])
    return blocks, np.stack([summed(by_point, residuals) for by_point in state.points], axis=1)


def assemble(
    state: Linearisation, roots: Array, deviation: Array, sigmas: Array, chunks: tuple[Chunk, ...]
) -> Normals:
    """Build the normal equations.

    Args:
        state: observation equations.
        roots: (N,) square root of each observation's weight, 1/px; 0 where a point cannot be projected.
        deviation: (U,) of the unknowns from their priors.
        sigmas: (U,) of the priors; 0 holds an unknown, inf frees it.
        chunks: from :func:`split_along_cable`.
    """
    held = sigmas == 0
    information = np.divide(1.0, sigmas**2, out=np.zeros_like(sigmas), where=~held)
    matrix, right = np.diag(information), -information * deviation
    residuals = np.where(roots > 0, state.residuals.T * roots, 0.0)
    blocks, point_right = point_equations(state, roots, chunks[-1].last if chunks else 0)
    parts = []
    for chunk in chunks:
        touched = [state.columns[state.image[rows.start]] for rows, _ in chunk.images]
        unknowns = np.unique(np.concatenate(touched)) if touched else np.zeros(0, dtype=np.int64)
        unknowns = unknowns[~held[unknowns]]
        place = np.full(len(sigmas), -1)
        place[unknowns] = np.arange(len(unknowns))
        cross = np.zeros((len(unknowns), 3, chunk.last - chunk.first))
        for (rows, local), columns in zip(chunk.images, touched, strict=True):
            free = ~held[columns]
            columns = columns[free]
            jacobian = state.orientation[:, :, rows][free] * roots[rows]
            flat = jacobian.reshape(len(columns), -1)
            matrix[np.ix_(columns, columns)] += flat @ flat.T
            right[columns] += flat @ residuals[:, rows].ravel()
            by_point = state.points[:, :, rows] * roots[rows]
            mixed = jacobian[:, None, 0] * by_point[:, 0]
            mixed += jacobian[:, None, 1] * by_point[:, 1]
            cross[np.ix_(place[columns], range(3), local)] += mixed
        mine = slice(chunk.first, chunk.last)
        parts.append(_Eliminated(chunk, unknowns, cross, blocks[mine], point_right[mine]))
    return Normals(matrix, right, np.flatnonzero(~held), tuple(parts))


def with_point_equations(normals: Normals, said: PointEquations) -> Normals:
    """The normal equations with pseudo-observations of the points; the shared unknowns come last."""
    own, more = len(normals.right), len(said.right)
    shared = np.arange(own, own + more)
    matrix = np.zeros((own + more, own + more))
    matrix[:own, :own] = normals.matrix
    matrix[own:, own:] = said.information + said.shared.T @ said.shared
    right = np.concatenate([normals.right, said.right + said.shared.T @ said.residuals])
    parts = []
    for part in normals.parts:
        rows = slice(part.chunk.first, part.chunk.last)
        by_point = said.points[rows]
        mixed = said.shared[rows].T[:, None] * by_point.T
        parts.append(
            _Eliminated(
                part.chunk,
                np.concatenate([part.unknowns, shared]),
                np.concatenate([part.cross, mixed]),
                part.blocks + by_point[:, :, None] * by_point[:, None, :],
                part.right + by_point * said.residuals[rows, None],
            )
        )
    return Normals(matrix, right, np.concatenate([normals.active, shared]), tuple(parts))


def solve(normals: Normals, damping: float) -> tuple[Array, Array]:
    """One damped step (Levenberg-Marquardt): (U,) for the orientations and (M, 3) for the points."""
    reduced, right, halves = _reduce(normals, damping)
    step = np.zeros(len(normals.right))
    if len(normals.active):
        step[normals.active] = cho_solve(cho_factor(reduced), right)
    point_steps = []
    for part, half in zip(normals.parts, halves, strict=True):
        moved = step[part.unknowns] @ part.cross.reshape(len(part.unknowns), -1)
        point_right = part.right - moved.reshape(3, -1).T
        point_steps.append(np.einsum("nji,njk,nk->ni", half, half, point_right, optimize=True))
    return step, np.concatenate(point_steps)


def point_steps(blocks: Array, right: Array) -> Array:
    """The points' steps (M, 3) with all else held, from :func:`point_equations`."""
    return np.einsum("mij,mj->mi", np.linalg.inv(_damped(blocks, 1e-6)), right)


def covariance(normals: Normals) -> Array:
    """Covariance of the orientations with the points eliminated, (U, U); zero where an unknown is held."""
    reduced, _, _ = _reduce(normals, 0.0)
    full = np.zeros_like(normals.matrix)
    full[np.ix_(normals.active, normals.active)] = cho_solve(cho_factor(reduced), np.eye(len(reduced)))
    return full


def gradient_through_points(normals: Normals, gains: Array) -> Array:
    """Derivative of functions of the points by the orientations, the points following their rays.

    A point moves by -C^-1 B' dx when the orientations move by dx (C, B' its blocks of the normal equations).

    Args:
        normals: at the solution.
        gains: (n, M, 3) derivative of n functions by the points.

    Returns:
        (n, U).
    """
    gradient = np.zeros((len(gains), len(normals.right)))
    for part in normals.parts:
        mine = gains[:, part.chunk.first : part.chunk.last]
        if not mine.any():
            continue
        inverse = np.linalg.inv(_damped(part.blocks, 0.0))
        moved = np.einsum("nmi,mij->njm", mine, inverse).reshape(len(gains), -1)
        gradient[:, part.unknowns] -= moved @ part.cross.reshape(len(part.unknowns), -1).T
    return gradient


def _reduce(normals: Normals, damping: float) -> tuple[Array, Array, list[Array]]:
    """The Schur complement over all points, its right-hand side, and for each part the inverted Cholesky
    factors (m, 3, 3) of its blocks: inverse = half^T half."""
    matrix, right, halves = normals.matrix.copy(), normals.right.copy(), []
    matrix[np.diag_indices_from(matrix)] *= 1 + damping
    for part in normals.parts:
        half = np.linalg.inv(np.linalg.cholesky(_damped(part.blocks, damping)))
        by_entry = np.ascontiguousarray(half.transpose(1, 2, 0))
        weighted = np.empty_like(part.cross)
        for i in range(3):  # lower triangles
            np.multiply(part.cross[:, 0], by_entry[i, 0], out=weighted[:, i])
            for j in range(1, i + 1):
                weighted[:, i] += part.cross[:, j] * by_entry[i, j]
        flat = weighted.reshape(len(part.unknowns), -1)
        matrix[np.ix_(part.unknowns, part.unknowns)] -= flat @ flat.T
        right[part.unknowns] -= flat @ np.einsum("mij,mj->im", half, part.right).ravel()
        halves.append(half)
    return matrix[np.ix_(normals.active, normals.active)], right[normals.active], halves


def _damped(blocks: Array, damping: float) -> Array:
    """Point blocks with their diagonal raised, and a floor so that a lost point keeps still."""
    trace = np.trace(blocks, axis1=1, axis2=2)[:, None, None]
    return blocks + np.eye(3) * (damping * trace / 3 + 1e-9 * trace + 1e-12)
