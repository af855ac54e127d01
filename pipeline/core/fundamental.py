"""The fundamental matrix from corresponding points alone, gross errors among them.

Takes (n, 2) undistorted points of two pictures and a seed; gives F with its inliers.  Leaves out what follows
from F: :mod:`pipeline.core.epipolar`, the door to this module.

Sources: R. Hartley, "In defense of the eight-point algorithm", IEEE PAMI 19(6), 1997; P. Torr and
A. Zisserman, "MLESAC", CVIU 78, 2000 (MSAC's truncated cost); Hartley and Zisserman 2003, section 11.4.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.errors import StageError
from pipeline.core.rotations import cross_matrix, rotation_from_vector
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class FundamentalOptions:
    """How F is searched for.

    Attributes:
        noise_sigma: standard deviation of a coordinate, in the unit of the points (pixels).
        gate: pairs farther than this many sigmas (Sampson distance) are outliers.
        confidence: wanted probability that one sample was free of outliers.
        largest_sample_count: most samples drawn.
        seed: of the random samples.
    """

    noise_sigma: float = 0.5
    gate: float = 2.5
    confidence: float = 0.9999
    largest_sample_count: int = 4000
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class FundamentalEstimate:
    """Fundamental matrix with what supports it.

    Attributes:
        F: (3, 3), rank 2, Frobenius norm 1.
        inliers: (n,) bool.
        rms: root mean square Sampson distance of the inliers, in the unit of the points.
        sample_count: samples drawn.
    """

    F: Array
    inliers: NDArray[np.bool_]
    rms: float
    sample_count: int


def homogeneous(points: ArrayLike) -> Array:
    """(n, 2) to (n, 3) with a last coordinate of 1."""
    xy = np.asarray(points, dtype=float)
    return np.concatenate([xy, np.ones((len(xy), 1))], axis=1)


def sampson_distances(F: Array, points1: ArrayLike, points2: ArrayLike) -> Array:
    """Sampson distances (n,), not negative, in the unit of the points.

    First order of the distance from the pair (x1, y1, x2, y2) to the epipolar relation.
    Hartley and Zisserman, "Multiple View Geometry", 2nd ed. 2003, equation (11.9).
    """
    return np.abs(_signed_sampson(F, homogeneous(points1), homogeneous(points2)))


def estimate_fundamental(
    points1: ArrayLike, points2: ArrayLike, options: FundamentalOptions | None = None
) -> FundamentalEstimate:
    """Estimate F from (n, 2) pairs: eight-point in MSAC, then Levenberg-Marquardt on Sampson distances.

    Args:
        points1, points2: (n, 2), undistorted.
        options: noise, gate and seed.

    Raises:
        StageError: fewer than eight pairs, or no F that eight of them agree on.
    """
    choice = options or FundamentalOptions()
    first, second = np.asarray(points1, dtype=float), np.asarray(points2, dtype=float)
    if len(first) < 8 or first.shape != second.shape:
        raise StageError("epipolar", f"{len(first)} pairs do not determine F", "give at least 8 pairs")
    T1, T2 = _normalisation(first), _normalisation(second)
    F, drawn = _best_sample(first, second, T1, T2, choice)
    bound = choice.gate * choice.noise_sigma
    for _ in range(3):
        inliers = sampson_distances(F, first, second) < bound
        if inliers.sum() < 8:
            raise StageError(
                "epipolar", f"only {inliers.sum()} of {len(first)} pairs agree on one F", "check the matches"
            )
        F = _refined(F, first[inliers], second[inliers], T1, T2)
    distances = sampson_distances(F, first, second)
    inliers = distances < bound
    rms = float(np.sqrt(np.mean(distances[inliers] ** 2))) if inliers.any() else float("nan")
    return FundamentalEstimate(F=F, inliers=inliers, rms=rms, sample_count=drawn)


def eight_point(points1: ArrayLike, points2: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """Normalised eight-point algorithm on (n, 2) pairs, rank 2 enforced, Frobenius norm 1."""
    first, second = np.asarray(points1, dtype=float), np.asarray(points2, dtype=float)
    T1, T2 = _normalisation(first), _normalisation(second)
    root = np.ones(len(first)) if weights is None else np.sqrt(np.asarray(weights, dtype=float))
    return _scaled(
        T2.T @ _linear((homogeneous(first) @ T1.T)[None], (homogeneous(second) @ T2.T)[None], root)[0] @ T1
    )


def _best_sample(
    first: Array, second: Array, T1: Array, T2: Array, choice: FundamentalOptions
) -> tuple[Array, int]:
    """The F of eight random pairs with the smallest truncated cost; samples are drawn 50 at a time."""
    rng, bound2 = np.random.default_rng(choice.seed), (choice.gate * choice.noise_sigma) ** 2
    m1, m2 = homogeneous(first), homogeneous(second)
    best, best_cost, drawn, needed = np.zeros((3, 3)), np.inf, 0, choice.largest_sample_count
    while drawn < min(needed, choice.largest_sample_count):
        samples = np.argsort(rng.random((50, len(first))), axis=1)[:, :8]
        for F in T2.T @ _linear(m1[samples] @ T1.T, m2[samples] @ T2.T, np.ones(8)) @ T1:
            distances2 = _signed_sampson(F, m1, m2) ** 2
            cost = float(np.sum(np.minimum(distances2, bound2)))
            if cost < best_cost:
                best, best_cost = F, cost
                needed = _samples_needed(float(np.mean(distances2 < bound2)), choice.confidence)
        drawn += 50
    return _scaled(best), drawn


def _signed_sampson(F: Array, m1: Array, m2: Array) -> Array:
    l2, l1 = m1 @ F.T, m2 @ F
    slope = np.sqrt(np.sum(l1[:, :2] ** 2, axis=1) + np.sum(l2[:, :2] ** 2, axis=1))
    return np.sum(m2 * l2, axis=1) / np.maximum(slope, 1e-300)


def _samples_needed(share: float, confidence: float) -> int:
    clean = min(max(share**8, 1e-12), 1 - 1e-12)
    return int(np.ceil(np.log(1 - confidence) / np.log1p(-clean)))


def _linear(m1: Array, m2: Array, root: Array) -> Array:
    """(s, 3, 3) rank-2 solutions of m2^T F m1 = 0 for s samples of normalised points (s, n, 3)."""
    design = (m2[..., :, None] * m1[..., None, :]).reshape(*m1.shape[:2], 9) * root[:, None]
    F = np.linalg.eigh(np.swapaxes(design, 1, 2) @ design)[1][..., 0].reshape(-1, 3, 3)
    left, singular, right = np.linalg.svd(F)
    singular[:, 2] = 0
    return (left * singular[:, None, :]) @ right


def _normalisation(points: Array) -> Array:
    """Similarity (3, 3) that moves the centre to 0 and the mean distance to sqrt 2 (Hartley 1997)."""
    centre = points.mean(axis=0)
    scale = np.sqrt(2) / max(float(np.mean(np.linalg.norm(points - centre, axis=1))), 1e-300)
    return np.array([[scale, 0, -scale * centre[0]], [0, scale, -scale * centre[1]], [0, 0, 1]])


def _scaled(F: Array) -> Array:
    return F / max(float(np.linalg.norm(F)), 1e-300)


def _refined(F: Array, first: Array, second: Array, T1: Array, T2: Array) -> Array:
    """Levenberg-Marquardt on Sampson distances over F = T2^T U diag(cos t, sin t, 0) V^T T1.

    Seven parameters, so rank 2 holds by itself: A. Bartoli and P. Sturm, "Nonlinear estimation of the
    fundamental matrix with minimal parameters", IEEE PAMI 26(3), 2004.
    """
    left, singular, right = np.linalg.svd(np.linalg.inv(T2).T @ F @ np.linalg.inv(T1))
    state = (left, float(np.arctan2(singular[1], singular[0])), right.T)
    m1, m2 = homogeneous(first), homogeneous(second)
    damping, distances = 1e-4, _signed_sampson(_compose(state, T1, T2), m1, m2)
    for _ in range(30):
        jacobian = _jacobian(state, m1, m2, T1, T2)
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ distances
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
        trial = _moved(state, step)
        trial_distances = _signed_sampson(_compose(trial, T1, T2), m1, m2)
        gain = distances @ distances - trial_distances @ trial_distances
        if gain < 0:
            damping *= 10
            if damping > 1e8:
                break
            continue
        state, distances, damping = trial, trial_distances, damping / 10
        if gain <= 1e-10 * (distances @ distances) + 1e-25:
            break
    return _scaled(_compose(state, T1, T2))


State = tuple[Array, float, Array]


def _moved(state: State, step: Array) -> State:
    U, angle, V = state
    return U @ rotation_from_vector(step[:3]), angle + step[6], V @ rotation_from_vector(step[3:6])


def _compose(state: State, T1: Array, T2: Array) -> Array:
    U, angle, V = state
    return T2.T @ U @ np.diag([np.cos(angle), np.sin(angle), 0]) @ V.T @ T1


def _jacobian(state: State, m1: Array, m2: Array, T1: Array, T2: Array) -> Array:
    """(n, 7), the slope of the Sampson denominator left out (it vanishes with the distance)."""
    U, angle, V = state
    F = _compose(state, T1, T2)
    slope = np.linalg.norm(np.concatenate([(m1 @ F.T)[:, :2], (m2 @ F)[:, :2]], axis=1), axis=1)
    middle = np.diag([np.cos(angle), np.sin(angle), 0])
    turns = cross_matrix(np.eye(3))
    parts = [T2.T @ U @ turn @ middle @ V.T @ T1 for turn in turns]
    parts += [T2.T @ U @ middle @ turn.T @ V.T @ T1 for turn in turns]
    parts.append(T2.T @ U @ np.diag([-np.sin(angle), np.cos(angle), 0]) @ V.T @ T1)
    return np.stack([np.sum(m2 * (m1 @ part.T), axis=1) / slope for part in parts], axis=1)
