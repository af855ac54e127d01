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

BATCH = 16
"""So many random samples are compared at a time: of good matches fewer would do."""

LEAST_GAIN = 1e-4
"""The refinement ends when a step changes the cost by no more than this share: a hundredth of a sigma."""

TURNS = cross_matrix(np.eye(3))
"""Derivatives of a rotation by its vector, about the three axes."""


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


@dataclass(frozen=True)
class _Pairs:
    """Pairs of points prepared for many F: (3, n) homogeneous, and (n, 9) their products m2_i m1_j."""

    first: Array
    second: Array
    products: Array

    @staticmethod
    def of(points1: ArrayLike, points2: ArrayLike) -> "_Pairs":
        m1, m2 = homogeneous(points1), homogeneous(points2)
        products = (m2[:, :, None] * m1[:, None, :]).reshape(-1, 9)
        return _Pairs(np.ascontiguousarray(m1.T), np.ascontiguousarray(m2.T), products)

    def slopes(self, F: Array) -> Array:
        """Length of the gradient of m2^T F m1 by the four coordinates, (n,) or (s, n) for F (s, 3, 3)."""
        l2, l1 = F[..., :2, :] @ self.first, np.swapaxes(F, -1, -2)[..., :2, :] @ self.second
        squared = l2[..., 0, :] ** 2 + l2[..., 1, :] ** 2 + l1[..., 0, :] ** 2 + l1[..., 1, :] ** 2
        return np.sqrt(squared)

    def signed(self, F: Array) -> Array:
        """Signed Sampson distances, (n,) or (s, n) for F (s, 3, 3)."""
        algebraic = F.reshape(*F.shape[:-2], 9) @ self.products.T
        return algebraic / np.maximum(self.slopes(F), 1e-300)


def sampson_distances(F: Array, points1: ArrayLike, points2: ArrayLike) -> Array:
    """Sampson distances (n,), not negative, in the unit of the points.

    First order of the distance from the pair (x1, y1, x2, y2) to the epipolar relation.
    Hartley and Zisserman, "Multiple View Geometry", 2nd ed. 2003, equation (11.9).
    """
    return np.abs(_Pairs.of(points1, points2).signed(F))


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
    pairs, used = _Pairs.of(first, second), np.zeros(len(first), dtype=bool)
    for _ in range(3):
        inliers = np.abs(pairs.signed(F)) < bound
        if inliers.sum() < 8:
            raise StageError(
                "epipolar", f"only {inliers.sum()} of {len(first)} pairs agree on one F", "check the matches"
            )
        if (inliers == used).all():
            break
        F, used = _refined(F, first[inliers], second[inliers], T1, T2), inliers
    distances = np.abs(pairs.signed(F))
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
    """The F of eight random pairs with the smallest truncated cost; samples are drawn in batches."""
    rng, bound2 = np.random.default_rng(choice.seed), (choice.gate * choice.noise_sigma) ** 2
    pairs = _Pairs.of(first, second)
    n1, n2 = homogeneous(first) @ T1.T, homogeneous(second) @ T2.T
    best, best_cost, drawn, needed = np.zeros((3, 3)), np.inf, 0, choice.largest_sample_count
    while drawn < min(needed, choice.largest_sample_count):
        samples = np.argpartition(rng.random((BATCH, len(first))), 7, axis=1)[:, :8]
        candidates = T2.T @ _linear(n1[samples], n2[samples], np.ones(8)) @ T1
        distances2 = pairs.signed(candidates) ** 2
        costs = np.minimum(distances2, bound2).sum(axis=1)
        number = int(np.argmin(costs))
        if costs[number] < best_cost:
            best, best_cost = candidates[number], float(costs[number])
            needed = _samples_needed(float(np.mean(distances2[number] < bound2)), choice.confidence)
        drawn += BATCH
    return _scaled(best), drawn


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
    pairs = _Pairs.of(first, second)
    damping, distances = 1e-4, pairs.signed(_compose(state, T1, T2))
    normal, gradient = _normal_equations(state, distances, pairs, T1, T2)
    for _ in range(30):
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
        trial = _moved(state, step)
        trial_distances = pairs.signed(_compose(trial, T1, T2))
        gain = distances @ distances - trial_distances @ trial_distances
        if abs(gain) <= LEAST_GAIN * (distances @ distances) + 1e-25:
            break
        if gain < 0:
            damping *= 10
            if damping > 1e8:
                break
            continue
        state, distances, damping = trial, trial_distances, damping / 10
        normal, gradient = _normal_equations(state, distances, pairs, T1, T2)
    return _scaled(_compose(state, T1, T2))


State = tuple[Array, float, Array]


def _moved(state: State, step: Array) -> State:
    U, angle, V = state
    turns = rotation_from_vector(step[:6].reshape(2, 3))
    return U @ turns[0], angle + step[6], V @ turns[1]


def _compose(state: State, T1: Array, T2: Array) -> Array:
    U, angle, V = state
    return T2.T @ U @ np.diag([np.cos(angle), np.sin(angle), 0]) @ V.T @ T1


def _normal_equations(
    state: State, distances: Array, pairs: _Pairs, T1: Array, T2: Array
) -> tuple[Array, Array]:
    """(7, 7) and (7,), the slope of the Sampson denominator left out (it vanishes with the distance)."""
    U, angle, V = state
    middle = np.diag([np.cos(angle), np.sin(angle), 0])
    by_left = U @ TURNS @ middle @ V.T
    by_right = U @ middle @ np.swapaxes(TURNS, 1, 2) @ V.T
    by_angle = U @ np.diag([-np.sin(angle), np.cos(angle), 0]) @ V.T
    parts = T2.T @ np.concatenate([by_left, by_right, by_angle[None]]) @ T1
    jacobian = (parts.reshape(7, 9) @ pairs.products.T) / pairs.slopes(_compose(state, T1, T2))
    return jacobian @ jacobian.T, jacobian @ distances
