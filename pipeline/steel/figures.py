"""Axes and planes of all stations matched in the site frame, and named.

Takes the features of each station and where the stations stand, as their targets place them; gives the same
with names: A001 and so on for axes, P001 for planes, that two stations or more see.  Two figures are one if
they lie as near to each other as their own sigmas and those of the stations' poses allow, look alike and
overlap.  Where a second one in the same station would nearly do, neither is taken.  Leaves out finding
figures (``axes.py``, ``planes.py``) and judging them once adjusted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.stats import chi2

from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array
from pipeline.steel.records import Feature, FeatureKind, StationFeatures, StationPose

MISSED = 1e-4
"""Two sightings of one figure are taken for two about this often."""
CLEAR = 4.0
"""A rival must lie off by more than the gate, times this in squares."""
FARTHEST_M, FACING = 0.06, np.cos(np.radians(1.0))
"""Nothing farther apart, or turned more, is one figure, however badly the stations are known."""
ALIKE_SHARE, ALIKE_M = 0.05, 0.004
"""Radii of one member differ by this share, and so much besides, at most."""
OVERLAP = 0.3
"""Part of the shorter piece of an axis that the other station must see as well."""

LETTERS = {FeatureKind.LINE: "A", FeatureKind.PLANE: "P"}


@dataclass(frozen=True, kw_only=True)
class _Sighting:
    """A figure in the site frame: whose it is, and the feature with its place and frame turned."""

    station: int
    number: int
    feature: Feature


def name_figures(found: Sequence[StationFeatures], poses: Sequence[StationPose]) -> list[StationFeatures]:
    """Name the axes and planes that stations share.

    Args:
        found: features of each station; points are left as they are.
        poses: of the same stations, with the covariances among them.

    Returns:
        The features in the order of ``found``; what nobody else sees stays unnamed.
    """
    names: dict[tuple[int, int], str] = {}
    for kind, letter in LETTERS.items():
        seen = [
            _Sighting(station=s, number=n, feature=_in_site(f, poses[s]))
            for s, one in enumerate(found)
            for n, f in enumerate(one.features)
            if f.kind is kind
        ]
        for count, group in enumerate(_groups(seen, poses), start=1):
            for k in group:
                names[seen[k].station, seen[k].number] = f"{letter}{count:03d}"
    return [
        StationFeatures(
            station=one.station,
            features=tuple(
                f if f.kind is FeatureKind.POINT else replace(f, name=names.get((s, n), ""))
                for n, f in enumerate(one.features)
            ),
        )
        for s, one in enumerate(found)
    ]


def _in_site(feature: Feature, pose: StationPose) -> Feature:
    return replace(
        feature,
        place=pose.rotation @ feature.place + pose.translation,
        direction=pose.rotation @ feature.direction,
        frame=feature.frame @ pose.rotation.T,
    )


def _groups(seen: Sequence[_Sighting], poses: Sequence[StationPose]) -> list[list[int]]:
    """Numbers of the sightings of each figure, the figure with the most first; clear ones alone."""
    near = _near(seen)
    squares = {pair: _square(seen[pair[0]], seen[pair[1]], poses) for pair in near}
    partners: dict[tuple[int, int], list[tuple[float, int]]] = {}
    for (i, j), square in squares.items():
        partners.setdefault((i, seen[j].station), []).append((square, j))
        partners.setdefault((j, seen[i].station), []).append((square, i))
    best = {}
    for (i, station), choices in partners.items():
        gate = float(chi2.isf(MISSED, len(seen[i].feature.covariance)))
        inside = [j for square, j in choices if square < CLEAR * gate]
        if len(inside) == 1 and min(choices)[0] < gate:
            best[i, station] = inside[0]
    pairs = [(i, j) for (i, s), j in best.items() if best.get((j, seen[i].station)) == i and i < j]
    if not pairs:
        return []
    first, second = np.array(pairs).T
    graph = coo_array((np.ones(len(pairs)), (first, second)), shape=(len(seen), len(seen)))
    count, label = connected_components(graph, directed=False)
    groups = [np.flatnonzero(label == number).tolist() for number in range(count)]
    # by a chain of matches one station may come in twice: then none of them can be trusted
    clear = [g for g in groups if len(g) > 1 and len({seen[k].station for k in g}) == len(g)]
    return sorted(clear, key=lambda g: (-len(g), g))


def _near(seen: Sequence[_Sighting]) -> list[tuple[int, int]]:
    """Pairs in different stations that look alike and lie near each other."""
    if len(seen) < 2:
        return []
    places = np.array([one.feature.place for one in seen])
    directions = np.array([one.feature.direction for one in seen])
    reaches = np.array([one.feature.reach_m for one in seen])
    radii = np.array([one.feature.radius_m for one in seen])
    stations = np.array([one.station for one in seen])
    away = places[None] - places[:, None]
    cosine = directions @ directions.T
    along = np.einsum("ijk,ik->ij", away, directions)
    across = np.sqrt(np.maximum(np.sum(away**2, axis=2) - along**2, 0))
    if seen[0].feature.kind is FeatureKind.LINE:
        overlap = reaches[:, None] + reaches[None] - np.abs(along)
        good = (np.abs(cosine) > FACING) & (
            overlap > 2 * OVERLAP * np.minimum(reaches[:, None], reaches[None])
        )
        good &= across < FARTHEST_M + np.abs(along) * np.sqrt(1 - FACING**2)
        good &= np.abs(radii[:, None] - radii[None]) < ALIKE_M + ALIKE_SHARE * radii[:, None]
    else:
        # both sides of a thin wall are two planes
        good = (cosine > FACING) & (across < 1.5 * (reaches[:, None] + reaches[None]))
        good &= np.abs(along) < FARTHEST_M + across * np.sqrt(1 - FACING**2)
    i, j = np.nonzero(good & (stations[:, None] < stations[None]))
    return list(zip(i.tolist(), j.tolist(), strict=True))


def _square(one: _Sighting, other: _Sighting, poses: Sequence[StationPose]) -> float:
    """Squared distance of two sightings over their covariance; infinite beyond all bounds."""
    a, b = one.feature, other.feature
    frame, middle = a.frame, _between(a, b)
    values, mine = _at(a, frame, middle)
    theirs, yours = _at(b, frame, middle)
    difference = values - theirs
    if np.linalg.norm(difference[:-2]) > FARTHEST_M:
        return np.inf
    first, second = poses[one.station], poses[other.station]
    A, B = _by_pose(a.kind, frame, middle, first), _by_pose(a.kind, frame, middle, second)
    covariance = mine + yours + A @ first.covariance @ A.T + B @ second.covariance @ B.T
    if len(first.among):
        shared = A @ first.among[other.station] @ B.T
        covariance -= shared + shared.T
    return float(difference @ np.linalg.solve(covariance, difference))


def _between(a: Feature, b: Feature) -> Array:
    """(3,) on the first figure: between the two places, nearer to the one with the shorter reach."""
    share = a.reach_m / max(a.reach_m + b.reach_m, 1e-9)
    step = share * (b.place - a.place)
    along = (step @ a.direction) * a.direction
    return np.asarray(a.place + (along if a.kind is FeatureKind.LINE else step - along))


def _at(feature: Feature, frame: Array, place: Array) -> tuple[Array, Array]:
    """Values of a figure at a place (3,) in another's frame (offsets, then slopes), and their covariance."""
    away = place - feature.place
    sign = np.sign(feature.direction @ frame[2])
    direction = feature.direction / (feature.direction @ frame[2])
    slopes = frame[:2] @ direction
    turn = frame[:2] @ feature.frame[:2].T
    if feature.kind is FeatureKind.LINE:
        along = float(away @ feature.direction)
        offsets = frame[:2] @ (along * feature.direction - away)
        gain = np.block([[turn, along * turn], [np.zeros((2, 2)), sign * turn]])
    else:
        offsets = np.array([-(away @ direction)])
        across = feature.frame[:2] @ away
        gain = np.block([[np.array([[sign]]), -sign * across[None]], [np.zeros((2, 1)), sign * turn]])
    return np.concatenate([offsets, slopes]), gain @ feature.covariance @ gain.T


def _by_pose(kind: FeatureKind, frame: Array, place: Array, pose: StationPose) -> Array:
    """(k, 6) derivative of those values by the station's pose, as perturbed in :class:`StationPose`."""
    lever = np.concatenate([-cross_matrix(place - pose.translation), np.eye(3)], axis=1)
    rows = frame[:2] if kind is FeatureKind.LINE else frame[2:]
    slopes = np.concatenate([-frame[:2] @ cross_matrix(frame[2]), np.zeros((2, 3))], axis=1)
    return np.concatenate([rows @ lever, slopes])
