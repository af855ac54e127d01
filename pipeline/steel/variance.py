"""How good the observations are: local redundancy, tests, variance components, weights by equation (7).

Takes the adjusted groups with their covariances; gives a test value for each observation, a variance
component for each kind, and new weights.

An observation of k values with cofactor Q, weight w and adjusted covariance H (of the computed values) is
judged by the residual e that it would have had if it had taken no part, whatever its weight was: in the
eigenbasis of Q^-1/2 H Q^-1/2 with eigenvalues h, and y = Q^-1/2 v rotated into it,
    e' Cov(e)^-1 e = sum y^2 / ((1 - w h) (1 + (1 - w) h)),      redundancy = sum (1 - w h).
With w = 1 that is Baarda's v' Q_v^-1 v ("A testing procedure for use in geodetic networks", 1968), with w = 0
the test of an observation that is left out and may come back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from pipeline.core.vocabulary import Array
from pipeline.steel.equations import Covariances, Rows
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.state import Component, Group

Numbers = NDArray[np.int64]

LEAST_REDUNDANCY = 1e-3
"""A direction with less of it is not checked by any other observation."""


@dataclass(frozen=True, kw_only=True)
class Tested:
    """What the adjustment says of the observations of a group, for the covariances as stated.

    Attributes:
        ratio: (n,) e' Cov(e)^-1 e over the number of checked values: T of equation (7).
        checked: (n,) number of values, 0 to k, that other observations check.
        redundancy: (n,) sum of the local redundancies, 0 to k.
        predicted: (n, k) observed minus what all the others say, 0 where they say nothing.
        square: (n,) square of the residuals over the cofactor, times the weight.
        weight: (n,) as it was.
        residuals: (n, k) observed minus adjusted.
        adjusted: (n, k, k) covariance of the adjusted values.
    """

    ratio: Array
    checked: Array
    redundancy: Array
    predicted: Array
    square: Array
    weight: Array
    residuals: Array
    adjusted: Array


def tested(rows: Rows, weights: Array, found: Covariances, places: Numbers, cofactor: Array) -> Tested:
    """Test the observations of a group.

    Args:
        rows: their equations at the solution.
        weights: (n,) that they had.
        found: covariances at the solution.
        places: (n,) where each stands in ``found.between``.
        cofactor: (n, k, k) their covariances with weight 1.
    """
    H = adjusted_covariance(rows, found, places)
    root = np.linalg.cholesky(cofactor)
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ H @ inverse.transpose(0, 2, 1))
    values = np.maximum(values, 0)
    y = np.einsum("nji,njk,nk->ni", vectors, inverse, rows.linear.residuals)
    w = weights[:, None]
    free = 1 - w * values
    can = free > LEAST_REDUNDANCY
    safe = np.where(can, free, 1)
    checked = can.sum(axis=1)
    power = np.where(can, y**2 / (safe * (1 + (1 - w) * values)), 0)
    predicted = np.einsum("nij,njk,nk->ni", root, vectors, np.where(can, y / safe, 0))
    return Tested(
        ratio=power.sum(axis=1) / np.maximum(checked, 1),
        checked=checked.astype(float),
        redundancy=np.clip(free, 0, 1).sum(axis=1),
        predicted=predicted,
        square=weights * np.sum(y**2, axis=1),
        weight=weights,
        residuals=rows.linear.residuals,
        adjusted=H,
    )


def adjusted_covariance(rows: Rows, found: Covariances, places: Numbers) -> Array:
    """(n, k, k) covariance of the values that the adjusted stations and features give."""
    stations = len(found.stations) // 6
    blocks = found.stations.reshape(stations, 6, stations, 6)
    A, B = rows.linear.by_station, rows.linear.by_feature
    size = B.shape[2]
    own = blocks[rows.station, :, rows.station, :]
    cross = A @ found.between[places][:, :, :size] @ B.transpose(0, 2, 1)
    feature = B @ found.features[rows.feature][:, :size, :size] @ B.transpose(0, 2, 1)
    return A @ own @ A.transpose(0, 2, 1) + cross + cross.transpose(0, 2, 1) + feature


def components(
    groups: Sequence[Group],
    results: Sequence[Tested],
    before: dict[Component, float],
    options: RegisterOptions,
) -> dict[Component, float]:
    """Variance of unit weight of each kind, the stated accuracy counting as a few observations.

    W. Förstner, "Ein Verfahren zur Schätzung von Varianz- und Kovarianzkomponenten", AVN 86, 1979: the
    weighted square of a kind's residuals over its redundancy, repeated by the caller.  Observations that
    stand out from the middle half of their kind say nothing about the others: else one gross error would make
    all the others look bad, and itself good.
    """
    after = dict(before)
    for group, result in zip(groups, results, strict=True):
        if group.component is Component.CONTROL:
            continue  # too few to judge themselves
        good = (result.weight > 0) & (result.ratio < options.weight_bound * _typical(result))
        square = float(result.square[good].sum()) * before[group.component]
        redundancy = float(result.redundancy[good].sum())
        prior = options.prior_redundancy
        after[group.component] = (square + prior) / (redundancy + prior) if redundancy + prior > 0 else 1.0
    return after


def _typical(result: Tested) -> float:
    """The ratio that half of the checked observations stay below, over that of noise as stated."""
    seen = result.checked > 0
    if not seen.any():
        return 1.0
    expected = np.median(chi2.median(result.checked[seen]) / result.checked[seen])
    return max(float(np.median(result.ratio[seen]) / expected), 1e-12)


def reweighted(result: Tested, bound: float) -> Array:
    """Equation (7): weights (n,) relative to the variance of unit weight.

    An observation whose own posterior variance is ``bound`` times that of its kind or more gets its own.
    """
    return np.where(result.ratio < bound, 1.0, 1 / np.maximum(result.ratio, 1.0))
