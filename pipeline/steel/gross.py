"""Gross errors by name: which station, which target, how far and which way, moved or misnamed.

Takes the adjusted network; gives one record for each observation of a feature that was left out.  A target
that stands where another one belongs was misnamed; one that stands a little off was moved, and all stations
that see it at the new place are told together.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from pipeline.core.vocabulary import Array
from pipeline.steel.adjustment import Adjusted
from pipeline.steel.network import Network
from pipeline.steel.records import FeatureKind
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import GrossError, GrossKind
from pipeline.steel.state import Component, Group

FITS = 1e-4
"""A place fits a target unless noise would put it farther off less often than this."""
TURNED = 0.05
"""Slope from which an axis or a plane faces another way: two that are one differ by seconds."""
SLOPES = {Component.POINT: slice(0, 0), Component.LINE: slice(2, 4), Component.PLANE: slice(1, 3)}
"""Which values of an observation are slopes."""


@dataclass(frozen=True, kw_only=True)
class _LeftOut:
    """An observation without weight: its number in the network, seen place and offset in the site frame;
    whether it is an axis or a plane that faces another way than the one that it is named after."""

    observation: int
    place: Array
    offset: Array
    covariance: Array
    turned: bool = False


def name_gross_errors(
    network: Network, adjusted: Adjusted, options: RegisterOptions
) -> tuple[GrossError, ...]:
    """Say what is wrong with every observation that was left out, the largest offset first."""
    left_out = _left_out(network, adjusted)
    found = [_named(network, adjusted, one, left_out, options) for one in left_out]
    return tuple(sorted(found, key=lambda error: -error.size_mm))


def regrouped(network: Network, adjusted: Adjusted) -> tuple[Array, ...]:
    """Weights that leave out the smaller of two groups of stations that see a target at two places.

    Left out one by one, it is chance which group of equal size goes.  A target is moved while the survey goes
    on: where all stations of one group come before all of the other in the survey, and both groups are more
    than one station, the earlier place is right however many saw it; of equal groups the earlier.
    """
    weights = [values.copy() for values in adjusted.weights]
    doubtful = {int(network.feature[one.observation]) for one in _left_out(network, adjusted)}
    for group, values in zip(adjusted.groups, weights, strict=True):
        if group.component is not Component.POINT:
            continue
        for feature in sorted(doubtful):
            rows = np.flatnonzero(group.feature == feature)
            clusters = _clusters([_seen_at(network, adjusted, group, n) for n in rows])
            if not clusters or len(clusters[0]) == len(rows) or len(rows) < 3:
                continue
            values[rows] = 0.0
            values[rows[clusters[0]]] = 1.0
    return tuple(weights)


def _seen_at(network: Network, adjusted: Adjusted, group: Group, n: np.int64) -> _LeftOut:
    number, station = int(group.observation[n]), int(group.station[n])
    R = adjusted.state.rotations[station]
    return _LeftOut(
        observation=number,
        place=R @ network.seen[number].place + adjusted.state.translations[station],
        offset=np.zeros(3),
        covariance=adjusted.components[group.component] * R @ group.cofactor[n] @ R.T,
    )


def _clusters(seen: list[_LeftOut]) -> list[list[int]]:
    """Numbers of the observations that agree on a place, the largest group first, then the earliest."""
    clusters: list[list[int]] = []
    for number, one in enumerate(seen):
        for cluster in clusters:
            if all(_alike(one, seen[other]) for other in cluster):
                cluster.append(number)
                break
        else:
            clusters.append([number])
    clusters = sorted(clusters, key=lambda cluster: (-len(cluster), cluster[0]))
    if len(clusters) > 1 and len(clusters[1]) > 1 and clusters[1][-1] < clusters[0][0]:
        clusters[:2] = clusters[1::-1]
    return clusters


def _left_out(network: Network, adjusted: Adjusted) -> list[_LeftOut]:
    state = adjusted.state
    found = []
    for group, weights, test in zip(adjusted.groups, adjusted.weights, adjusted.tests, strict=True):
        if group.component in (Component.PLUMB, Component.CONTROL):
            continue
        for n in np.flatnonzero(weights == 0):
            number, station = int(group.observation[n]), int(group.station[n])
            feature, R = network.seen[number], state.rotations[station]
            place = R @ feature.place + state.translations[station]
            offset = R @ offset_in_station(group.component, test.predicted[n], feature.frame)
            turned = bool(np.linalg.norm(test.predicted[n][SLOPES[group.component]]) > TURNED)
            if turned:
                named = int(network.feature[number])
                offset = _off(group.component, place - state.places[named], state.frames[named, 2])
            own = _point_cofactor(group.component, group.cofactor[n], feature.frame)
            found.append(
                _LeftOut(
                    observation=number,
                    place=place,
                    offset=offset,
                    covariance=adjusted.components[group.component] * R @ own @ R.T,
                    turned=turned,
                )
            )
    return found


def offset_in_station(component: Component, predicted: Array, frame: Array) -> Array:
    """(3,) metres in the station frame, of the values of ``conditions.py``."""
    if component is Component.POINT:
        return predicted
    if component is Component.LINE:
        return predicted[:2] @ frame[:2]
    return predicted[0] * frame[2]


def _off(component: Component, away: Array, direction: Array) -> Array:
    """(3,) the part of ``away`` (3,) that leads off an axis, or off a plane."""
    along = (away @ direction) * direction
    return np.asarray(away - along if component is Component.LINE else along)


def _point_cofactor(component: Component, cofactor: Array, frame: Array) -> Array:
    if component is Component.POINT:
        return cofactor
    if component is Component.LINE:
        return frame[:2].T @ cofactor[:2, :2] @ frame[:2]
    return cofactor[0, 0] * np.outer(frame[2], frame[2])


def _named(
    network: Network, adjusted: Adjusted, one: _LeftOut, left_out: list[_LeftOut], options: RegisterOptions
) -> GrossError:
    station, feature = int(network.station[one.observation]), int(network.feature[one.observation])
    size = float(np.linalg.norm(one.offset))
    way = one.offset / max(size, 1e-12)
    fits = _fitting(network, adjusted, one.place, one.covariance, feature)
    misnamed = bool(fits) or one.turned or size > options.moved_at_most_m
    # two stations may see an axis at quite different places along it
    comparable = network.kinds[feature] is FeatureKind.POINT and not misnamed
    same = [
        other
        for other in left_out
        if comparable and network.feature[other.observation] == feature and _alike(one, other)
    ]
    together = [int(network.station[other.observation]) for other in same] or [station]
    return GrossError(
        station=network.stations[station],
        target=network.names[feature],
        kind=GrossKind.MISNAMED if misnamed else GrossKind.MOVED,
        offset_mm=(float(one.offset[0] * 1e3), float(one.offset[1] * 1e3), float(one.offset[2] * 1e3)),
        size_mm=size * 1e3,
        sigma_mm=float(np.sqrt(way @ (one.covariance + _feature_covariance(adjusted, feature)) @ way)) * 1e3,
        fits=fits,
        together=tuple(network.stations[s] for s in sorted(together)),
        instead=_instead(network, adjusted, feature, station),
    )


def _fitting(network: Network, adjusted: Adjusted, place: Array, covariance: Array, feature: int) -> str:
    """The other target that stands at a place (3,) in the site frame, or ""."""
    if network.kinds[feature] is not FeatureKind.POINT:
        return ""
    best, name = float(chi2.isf(FITS, 3)), ""
    seen = set(network.feature[_with_weight(adjusted)].tolist())
    for other in seen:
        if other == feature or network.kinds[other] is not FeatureKind.POINT:
            continue
        away = place - adjusted.state.places[other]
        if np.linalg.norm(away) > 1.0:
            continue
        whole = covariance + _feature_covariance(adjusted, other)
        distance = float(away @ np.linalg.solve(whole, away))
        if distance < best:
            best, name = distance, network.names[other]
    return name


def _with_weight(adjusted: Adjusted) -> Array:
    return np.concatenate(
        [
            group.observation[(weights > 0) & (group.observation >= 0)]
            for group, weights in zip(adjusted.groups, adjusted.weights, strict=True)
        ]
    )


def _feature_covariance(adjusted: Adjusted, feature: int) -> Array:
    return adjusted.covariances.features[feature][:3, :3]


def _alike(one: _LeftOut, other: _LeftOut) -> bool:
    if one is other:
        return True
    away = one.place - other.place
    distance = float(away @ np.linalg.solve(one.covariance + other.covariance, away))
    return distance < float(chi2.isf(FITS, 3))


def _instead(network: Network, adjusted: Adjusted, feature: int, station: int) -> str:
    others = network.station[network.feature == feature]
    rest = [int(s) for s in others if s != station]
    return network.stations[rest[0]] if len(rest) == 1 and feature not in network.control else ""
