"""Normal equations of all stations and features, the features eliminated (Schur complement).

Takes observation equations with their weights; gives steps, and covariances of stations, features and
adjusted observations.  The features' 4 x 4 blocks are inverted one by one; what remains are six unknowns a
station, solved densely: 134 stations are 804 unknowns, 0.03 s (Triggs et al., 2000, "Bundle adjustment, a
modern synthesis", section 6.1).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.conditions import Linear

POSE, MOST = 6, 4
"""Unknowns of a station, and the most that a feature has."""


@dataclass(frozen=True, kw_only=True)
class Rows:
    """Observation equations of one group, ready to be summed.

    Attributes:
        station, feature: (n,) int64.
        linear: residuals and derivatives.
        information: (n, k, k) inverse covariance, zero where an observation is left out.
    """

    station: NDArray[np.int64]
    feature: NDArray[np.int64]
    linear: Linear
    information: Array


@dataclass(frozen=True, kw_only=True)
class Normals:
    """Normal equations.

    Attributes:
        reduced: (6 S, 6 S) of the stations after the features are eliminated; held stations are identity.
        station_right: (6 S,) reduced right side.
        feature_inverse: (F, 4, 4) inverses of the features' own blocks.
        feature_right: (F, 4).
        station, feature: (N,) of each observation, sorted by feature.
        coupling: (N, 6, 4) blocks between the two.
        starts: (F + 1,) where each feature's observations begin.
        places: of each group, (n,) where its observations stand in that order.
    """

    reduced: Array
    station_right: Array
    feature_inverse: Array
    feature_right: Array
    station: NDArray[np.int64]
    feature: NDArray[np.int64]
    coupling: Array
    starts: NDArray[np.int64]
    places: tuple[NDArray[np.int64], ...]


def assemble(rows: tuple[Rows, ...], stations: int, features: int, held: NDArray[np.bool_]) -> Normals:
    """Sum the normal equations; ``held`` (S,) stations do not move."""
    own_station, own_feature = np.zeros((stations, POSE, POSE)), np.zeros((features, MOST, MOST))
    right_station, right_feature = np.zeros((stations, POSE)), np.zeros((features, MOST))
    couplings = []
    for row in rows:
        A = np.where(held[row.station, None, None], 0, row.linear.by_station)
        B = _padded(row.linear.by_feature)
        PA, PB = row.information @ A, row.information @ B
        np.add.at(own_station, row.station, A.transpose(0, 2, 1) @ PA)
        np.add.at(own_feature, row.feature, B.transpose(0, 2, 1) @ PB)
        np.add.at(right_station, row.station, np.einsum("nki,nk->ni", PA, row.linear.residuals))
        np.add.at(right_feature, row.feature, np.einsum("nki,nk->ni", PB, row.linear.residuals))
        couplings.append(A.transpose(0, 2, 1) @ PB)
    own_station[held] = np.eye(POSE)
    inverse = np.linalg.inv(_filled(own_feature))
    station = np.concatenate([row.station for row in rows])
    feature = np.concatenate([row.feature for row in rows])
    order = np.argsort(feature, kind="stable")
    station, feature, coupling = station[order], feature[order], np.concatenate(couplings)[order]
    starts = np.searchsorted(feature, np.arange(features + 1))
    reduced = np.zeros((stations, stations, POSE, POSE))
    reduced[np.arange(stations), np.arange(stations)] = own_station
    for f in range(features):
        run = slice(starts[f], starts[f + 1])
        arms = coupling[run].reshape(-1, MOST)
        count = len(arms) // POSE
        blocks = (arms @ inverse[f] @ arms.T).reshape(count, POSE, count, POSE).transpose(0, 2, 1, 3)
        _subtract(reduced, station[run], blocks)
    carried = np.einsum("nak,nkl,nl->na", coupling, inverse[feature], right_feature[feature])
    np.add.at(right_station, station, -carried)
    return Normals(
        reduced=reduced.transpose(0, 2, 1, 3).reshape(stations * POSE, -1),
        station_right=right_station.ravel(),
        feature_inverse=inverse,
        feature_right=right_feature,
        station=station,
        feature=feature,
        coupling=coupling,
        starts=starts,
        places=tuple(np.split(np.argsort(order), np.cumsum([len(row.station) for row in rows])[:-1])),
    )


def solve(normals: Normals, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Steps of the stations (S, 6) and of the features (F, 4).

    Raises:
        StageError: the observations do not hold a station, which is named.
    """
    factor = _factor(normals.reduced, names)
    stations = cho_solve(factor, normals.station_right).reshape(-1, POSE)
    right = normals.feature_right.copy()
    pulled = np.einsum("nak,na->nk", normals.coupling, stations[normals.station])
    np.add.at(right, normals.feature, -pulled)
    return stations, np.einsum("fij,fj->fi", normals.feature_inverse, right)


@dataclass(frozen=True, kw_only=True)
class Covariances:
    """Covariances at the solution.

    Attributes:
        stations: (6 S, 6 S), zero rows for held stations.
        features: (F, 4, 4).
        between: (N, 6, 4) of each observation's station and feature, in the order of :class:`Normals`.
    """

    stations: Array
    features: Array
    between: Array


def covariances(normals: Normals, held: NDArray[np.bool_], names: tuple[str, ...]) -> Covariances:
    """Invert the normal equations as far as stations, features and observations need it."""
    stations = len(held)
    full = cho_solve(_factor(normals.reduced, names), np.eye(stations * POSE))
    free = np.repeat(~held, POSE)
    full[~free] = full[:, ~free] = 0
    blocks = full.reshape(stations, POSE, stations, POSE).transpose(0, 2, 1, 3)
    features = normals.feature_inverse.copy()
    between = np.zeros_like(normals.coupling)
    for f in range(len(features)):
        run = slice(normals.starts[f], normals.starts[f + 1])
        mine = normals.station[run]
        arms = normals.coupling[run] @ features[f]
        among = blocks[np.ix_(mine, mine)].transpose(0, 2, 1, 3).reshape(len(mine) * POSE, len(mine) * POSE)
        flat = arms.reshape(-1, MOST)
        between[run] = -(among @ flat).reshape(-1, POSE, MOST)
        features[f] -= flat.T @ between[run].reshape(-1, MOST)
    return Covariances(stations=full, features=features, between=between)


def _factor(reduced: Array, names: tuple[str, ...]) -> tuple[Array, bool]:
    scale = 1 / np.sqrt(np.maximum(np.diag(reduced), 1e-300))
    equalised = reduced * scale[:, None] * scale[None, :]
    try:
        # numpy's: scipy's cho_factor is three times slower on 804 unknowns
        factor = np.linalg.cholesky(equalised)
        weakest = float(np.min(np.diag(factor)))
    except np.linalg.LinAlgError:
        weakest = 0.0
    if weakest < 1e-7:
        _, vectors = np.linalg.eigh(equalised)
        station = int(np.argmax(np.abs(vectors[:, 0]))) // POSE
        raise StageError(
            "register",
            f"the targets that station {names[station]} shares with others do not hold it in place",
            "give it at least three common targets that are not on one line",
        )
    # undo the scaling: (L / s) (L / s)^T is the matrix as it was
    return factor / scale[:, None], True


def _padded(by_feature: Array) -> Array:
    count, k, have = by_feature.shape
    return np.concatenate([by_feature, np.zeros((count, k, MOST - have))], axis=2)


def _filled(blocks: Array) -> Array:
    """Unused unknowns get a one on the diagonal, so that the blocks can be inverted."""
    unused = np.einsum("fii->fi", blocks) == 0
    return blocks + unused[:, :, None] * np.eye(MOST)


def _subtract(reduced: Array, station: NDArray[np.int64], blocks: Array) -> None:
    # control targets share the number of the base, where their blocks are zero
    if len(np.unique(station)) == len(station):
        reduced[station[:, None], station[None, :]] -= blocks
    else:
        np.subtract.at(reduced, (station[:, None], station[None, :]), blocks)
