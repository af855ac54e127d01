"""The reduced normal equations of a bundle adjustment.

Takes the observation equations (:class:`~pipeline.core.rig.Linearisation`) and priors; gives the damped
Gauss-Newton step and the covariance of the orientations.  Tie points are eliminated by the Schur complement
(Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, section 6.1), in chunks of neighbouring
points, so that memory follows the overlap of the frames and not the length of the survey.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from pipeline.core.rig import Linearisation, Observations
from pipeline.core.vocabulary import Array

Indices = NDArray[np.int64]
POINTS_PER_CHUNK = 2000


@dataclass(frozen=True)
class Chunk:
    """Points ``first`` to ``last``; for each image its observations and their points, counted from
    ``first``."""

    first: int
    last: int
    images: tuple[tuple[Indices, Indices], ...]


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
    """One chunk's part of the normal equations: (u,) unknowns, (u, 3m) cross terms, (m, 3, 3), (m, 3)."""

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


def split_along_cable(observations: Observations, points: int) -> tuple[Chunk, ...]:
    """Cut the points into runs of neighbours and group each run's observations by image."""
    image = observations.frame * (observations.camera.max(initial=0) + 1) + observations.camera
    chunks = []
    for first in range(0, points, POINTS_PER_CHUNK):
        last = min(first + POINTS_PER_CHUNK, points)
        inside = np.flatnonzero((observations.point >= first) & (observations.point < last))
        order = inside[np.argsort(image[inside], kind="stable")]
        groups = np.split(order, np.flatnonzero(np.diff(image[order])) + 1) if len(order) else []
        chunks.append(Chunk(first, last, tuple((g, observations.point[g] - first) for g in groups)))
    return tuple(chunks)


def assemble(
    state: Linearisation, roots: Array, deviation: Array, sigmas: Array, chunks: tuple[Chunk, ...]
) -> Normals:
    """Build the normal equations.

    Args:
        state: observation equations.
        roots: (N,) square root of each observation's weight, 1/px.
        deviation: (U,) of the unknowns from their priors.
        sigmas: (U,) of the priors; 0 holds an unknown, inf frees it.
        chunks: from :func:`split_along_cable`.
    """
    residuals = np.nan_to_num(state.residuals) * roots[:, None]
    orientation = np.nan_to_num(state.orientation) * roots[:, None, None]
    by_point = np.nan_to_num(state.points) * roots[:, None, None]
    held = sigmas == 0
    information = np.divide(1.0, sigmas**2, out=np.zeros_like(sigmas), where=~held)
    matrix, right = np.diag(information), -information * deviation
    parts = []
    for chunk in chunks:
        count = chunk.last - chunk.first
        blocks, point_right = np.zeros((count, 3, 3)), np.zeros((count, 3))
        touched = [state.columns[rows[0]] for rows, _ in chunk.images]
        unknowns = np.unique(np.concatenate(touched)) if touched else np.zeros(0, dtype=np.int64)
        unknowns = unknowns[~held[unknowns]]
        place = np.full(len(sigmas), -1)
        place[unknowns] = np.arange(len(unknowns))
        cross = np.zeros((len(unknowns), count, 3))
        for rows, local in chunk.images:
            columns = state.columns[rows[0]]
            free = np.flatnonzero(~held[columns])
            columns = columns[free]
            jacobian = orientation[rows][:, :, free]
            flat = jacobian.reshape(2 * len(rows), len(free))
            matrix[np.ix_(columns, columns)] += flat.T @ flat
            right[columns] += flat.T @ residuals[rows].ravel()
            jp = by_point[rows]
            blocks[local] += jp.transpose(0, 2, 1) @ jp
            point_right[local] += np.einsum("nij,ni->nj", jp, residuals[rows])
            mixed = (jacobian.transpose(0, 2, 1) @ jp).transpose(1, 0, 2)
            cross[place[columns][:, None], local[None, :]] += mixed
        parts.append(
            _Eliminated(chunk, unknowns, cross.reshape(len(unknowns), 3 * count), blocks, point_right)
        )
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
        mixed = (said.shared[rows].T[:, :, None] * by_point).reshape(more, -1)
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
    reduced, right, inverses = _reduce(normals, damping)
    step = np.zeros(len(normals.right))
    if len(normals.active):
        step[normals.active] = cho_solve(cho_factor(reduced), right)
    point_steps = [
        np.einsum("nij,nj->ni", inverse, part.right - (step[part.unknowns] @ part.cross).reshape(-1, 3))
        for part, inverse in zip(normals.parts, inverses, strict=True)
    ]
    return step, np.concatenate(point_steps)


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
        inverse = np.linalg.inv(_damped(part.blocks, 0.0))
        mine = gains[:, part.chunk.first : part.chunk.last]
        moved = np.einsum("nmi,mij->nmj", mine, inverse).reshape(len(gains), -1)
        gradient[:, part.unknowns] -= moved @ part.cross.T
    return gradient


def _reduce(normals: Normals, damping: float) -> tuple[Array, Array, list[Array]]:
    """The Schur complement over all points, its right-hand side, and each part's inverted blocks."""
    matrix, right, inverses = normals.matrix.copy(), normals.right.copy(), []
    matrix[np.diag_indices_from(matrix)] *= 1 + damping
    for part in normals.parts:
        inverse = np.linalg.inv(_damped(part.blocks, damping))
        cross = part.cross.reshape(len(part.unknowns), len(part.blocks), 3)
        weighted = np.einsum("umi,mij->umj", cross, inverse).reshape(part.cross.shape)
        matrix[np.ix_(part.unknowns, part.unknowns)] -= weighted @ part.cross.T
        right[part.unknowns] -= weighted @ part.right.ravel()
        inverses.append(inverse)
    return matrix[np.ix_(normals.active, normals.active)], right[normals.active], inverses


def _damped(blocks: Array, damping: float) -> Array:
    """Point blocks with their diagonal raised, and a floor so that a lost point keeps still."""
    trace = np.trace(blocks, axis1=1, axis2=2)[:, None, None]
    return blocks + np.eye(3) * (damping * trace / 3 + 1e-9 * trace + 1e-12)
