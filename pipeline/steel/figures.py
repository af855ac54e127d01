"""Axes and planes of all stations matched in the site frame, and named.

Takes the features of each station and where the stations stand, as their targets place them; gives the same
with names: A001 and so on for axes, P001 for planes, that two stations or more see.  Two figures are one if
they lie as near to each other as their own sigmas and those of the stations' poses allow, look alike and
overlap.  Where a second one in the same station would nearly do, neither is taken.  Leaves out finding
figures (``axes.py``, ``planes.py``) and judging them once adjusted.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
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
AT_ONCE = 256
"""Sightings compared at once with all others: memory must not grow with the square of their number."""

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
        found: features of each station; points are left as they are, and so are names given by hand: what
            matches such a figure gets its name.
        poses: of the same stations, with the covariances among them.

    Returns:
        The features in the order of ``found``; what nobody else sees stays unnamed.
    """
    names: dict[tuple[int, int], str] = {}
    by_hand = {f.name for one in found for f in one.features}
    for kind, letter in LETTERS.items():
        seen = [
            _Sighting(station=s, number=n, feature=_in_site(f, poses[s]))
            for s, one in enumerate(found)
            for n, f in enumerate(one.features)
            if f.kind is kind
        ]
        fresh = (name for count in range(1, 10**6) if (name := f"{letter}{count:03d}") not in by_hand)
        names |= _names_of(seen, _groups(seen, poses), fresh)
    return [
        StationFeatures(
            station=one.station,
            features=tuple(
                f if f.kind is FeatureKind.POINT else replace(f, name=names.get((s, n), f.name))
                for n, f in enumerate(one.features)
            ),
        )
        for s, one in enumerate(found)
    ]


def _names_of(
    seen: Sequence[_Sighting], groups: Sequence[Sequence[int]], fresh: Iterator[str]
) -> dict[tuple[int, int], str]:
    """(station, number) to name of the sightings in groups: the name that one of them has, or a fresh one."""
    names: dict[tuple[int, int], str] = {}
    taken = {(one.station, one.feature.name) for one in seen}
    for group in groups:
        by_hand = {seen[k].feature.name for k in group} - {""}
        if len(by_hand) > 1:
            continue  # two things, says the surveyor
        name = by_hand.pop() if by_hand else next(fresh)
        for k in group:
            own = (seen[k].station, name)
            if not seen[k].feature.name and own not in taken:
                names[seen[k].station, seen[k].number] = name
                taken.add(own)
    return names


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
    pairs: list[tuple[int, int]] = []
    if not seen:
        return pairs
    all_of_them = _Looks.of(seen)
    for first in range(0, len(seen), AT_ONCE):
        i, j = np.nonzero(_alike(all_of_them.where(slice(first, first + AT_ONCE)), all_of_them))
        pairs += zip((i + first).tolist(), j.tolist(), strict=True)
    return pairs


@dataclass(frozen=True)
class _Looks:
    """What is compared of many sightings of one kind: (n, 3), (n, 3), (n,), (n,), (n,)."""

    line: bool
    places: Array
    directions: Array
    reaches: Array
    radii: Array
    stations: NDArray[np.int64]

    @staticmethod
    def of(seen: Sequence[_Sighting]) -> "_Looks":
        features = [one.feature for one in seen]
        return _Looks(
            line=features[0].kind is FeatureKind.LINE,
            places=np.array([f.place for f in features]),
            directions=np.array([f.direction for f in features]),
            reaches=np.array([f.reach_m for f in features]),
            radii=np.array([f.radius_m for f in features]),
            stations=np.array([one.station for one in seen], dtype=np.int64),
        )

    def where(self, chosen: slice) -> "_Looks":
        return _Looks(self.line, *(getattr(self, f.name)[chosen] for f in fields(self)[1:]))


def _alike(some: _Looks, others: _Looks) -> NDArray[np.bool_]:
    """(n, m) whether the second is in a later station, near the first and like it."""
    away = others.places[None] - some.places[:, None]
    cosine = some.directions @ others.directions.T
    along = np.einsum("ijk,ik->ij", away, some.directions)
    across = np.sqrt(np.maximum(np.sum(away**2, axis=2) - along**2, 0))
    mine, theirs = some.reaches[:, None], others.reaches[None]
    if some.line:
        overlap = mine + theirs - np.abs(along)
        good = (np.abs(cosine) > FACING) & (overlap > 2 * OVERLAP * np.minimum(mine, theirs))
        good &= across < FARTHEST_M + np.abs(along) * np.sqrt(1 - FACING**2)
        radius = some.radii[:, None]
        good &= np.abs(radius - others.radii[None]) < ALIKE_M + ALIKE_SHARE * radius
    else:
        # both sides of a thin wall are two planes
        good = (cosine > FACING) & (across < 1.5 * (mine + theirs))
        good &= np.abs(along) < FARTHEST_M + across * np.sqrt(1 - FACING**2)
    return np.asarray(good & (some.stations[:, None] < others.stations[None]))


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
