"""Initial values: stations placed outward from the base, ring by ring, the best connected first.

Takes the network; gives poses, places of the features, and which observations the stations' majority speaks
against.  Each station is moved onto the points already placed with the Rodrigues matrix (paper, equations (1)
to (4)); where points alone place no other, named axes and planes may help (``figure_start.py``).  Leaves out
accuracy: errors grow along the rings here, and ``register.py`` removes that.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.figure_start import common_with, figure_motion, figures_apart
from pipeline.steel.network import Network
from pipeline.steel.records import FeatureKind
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.rodrigues import consensus, is_wide, level_motion, rodrigues_motion
from pipeline.steel.state import State
from pipeline.steel.unplaced import explain


@dataclass(frozen=True, kw_only=True)
class Start:
    """Initial values.

    Attributes:
        state: poses and features in the site frame.
        agrees: (n,) whether an observation lies where the majority sees its feature.
        order: stations as they were placed, the base first.
        parents: (S,) the placed station that each shares most targets with; -1 for the base.
        ring: (S,) how many set-ups a station is away from the base.
    """

    state: State
    agrees: NDArray[np.bool_]
    order: tuple[int, ...]
    parents: NDArray[np.int64]
    ring: NDArray[np.int64]


@dataclass(kw_only=True)
class _Placing:
    """What is placed so far; ``figures``: place and direction of axes and planes as first seen."""

    rotations: Array
    translations: Array
    places: dict[int, list[Array]]
    figures: dict[int, tuple[Array, Array]]
    order: list[int]
    parents: NDArray[np.int64]
    ring: NDArray[np.int64]


def place_stations(
    network: Network, level: bool, options: RegisterOptions, tell: Callable[[int, int], None]
) -> Start:
    """Place all stations and features.

    Args:
        network: who sees what.
        level: the stations' z axes are plumb: two common targets are enough.
        options: see there.
        tell: called with (stations placed, stations).

    Raises:
        StageError: a station cannot be placed; says which and why.
    """
    count = len(network.stations)
    seen = [network.points_of(station) for station in range(count)]
    placing = _Placing(
        rotations=np.tile(np.eye(3), (count, 1, 1)),
        translations=np.zeros((count, 3)),
        places={},
        figures={},
        order=[],
        parents=np.full(count, -1),
        ring=np.zeros(count, dtype=np.int64),
    )
    _add(placing, network, network.base, seen[network.base], np.eye(3), np.zeros(3))
    while len(placing.order) < count:
        if _place_ring(placing, network, seen, level, options, tell):
            continue
        if not _place_by_figures(placing, network, seen, level, options):
            raise explain(network, placing.order, seen, level, options)
    rotations, translations = _onto_control(network, placing, level)
    return _started(network, replace(placing, rotations=rotations, translations=translations), options)


def _place_ring(
    placing: _Placing,
    network: Network,
    seen: list[dict[int, int]],
    level: bool,
    options: RegisterOptions,
    tell: Callable[[int, int], None],
) -> bool:
    """Place every station that shares enough with those placed before; tells whether there was one."""
    ring = 1 + max(int(placing.ring[s]) for s in placing.order)
    outside = [s for s in range(len(seen)) if s not in placing.order]
    known = set(placing.places)
    reachable = [s for s in outside if len(known & seen[s].keys()) >= (2 if level else 3)]
    placed = False
    while reachable:
        station = max(reachable, key=lambda s: (len(placing.places.keys() & seen[s].keys()), -s))
        reachable.remove(station)
        if _place(placing, network, seen, station, level, options):
            placing.ring[station] = ring
            placed = True
            tell(len(placing.order), len(seen))
    return placed


def _place(
    placing: _Placing,
    network: Network,
    seen: list[dict[int, int]],
    station: int,
    level: bool,
    options: RegisterOptions,
) -> bool:
    common = sorted(placing.places.keys() & seen[station].keys())
    source = np.array([network.seen[seen[station][f]].place for f in common])
    target = np.array([np.mean(placing.places[f], axis=0) for f in common])
    sigma = network.largest_sigma_m([seen[station][f] for f in common])
    if not level and not is_wide(source, sigma):
        return False
    rotation, translation, inside = consensus(source, target, options.start_tolerance_m, level=level)
    if inside.sum() < (2 if level else 3) or (not level and not is_wide(source[inside], sigma)):
        return False
    shared = [len(seen[station].keys() & seen[s].keys()) for s in placing.order]
    placing.parents[station] = placing.order[int(np.argmax(shared))]
    wrong = {f for f, good in zip(common, inside, strict=True) if not good}
    kept = {f: n for f, n in seen[station].items() if f not in wrong}
    _add(placing, network, station, kept, rotation, translation)
    return True


def _place_by_figures(
    placing: _Placing, network: Network, seen: list[dict[int, int]], level: bool, options: RegisterOptions
) -> bool:
    """Place the one station that shares most with those placed, on points, axes and planes together."""
    outside = [s for s in range(len(seen)) if s not in placing.order]
    shared = {s: common_with(network, s, seen[s], placing.places, placing.figures) for s in outside}
    for station in sorted(outside, key=lambda s: (-len(shared[s]), s)):
        motion = figure_motion(shared[station], options.start_tolerance_m, level=level)
        if motion is None:
            continue
        mine = network.named_by(station)
        parent = max(placing.order, key=lambda s: (len(mine & network.named_by(s)), -s))
        placing.parents[station], placing.ring[station] = parent, 1 + placing.ring[parent]
        _add(placing, network, station, seen[station], *motion)
        return True
    return False


def _add(
    placing: _Placing,
    network: Network,
    station: int,
    seen: dict[int, int],
    rotation: Array,
    translation: Array,
) -> None:
    placing.rotations[station], placing.translations[station] = rotation, translation
    placing.order.append(station)
    for feature, observation in seen.items():
        place = rotation @ network.seen[observation].place + translation
        placing.places.setdefault(feature, []).append(place)
    for number in network.figures_of(station):
        figure = network.seen[number]
        place, direction = rotation @ figure.place + translation, rotation @ figure.direction
        placing.figures.setdefault(int(network.feature[number]), (place, direction))


def _onto_control(network: Network, placing: _Placing, level: bool) -> tuple[Array, Array]:
    """The poses moved from the base's frame into that of the control targets, where there are any."""
    common = sorted(placing.places.keys() & network.control.keys())
    if not network.control:
        return placing.rotations, placing.translations
    source = np.array([np.mean(placing.places[f], axis=0) for f in common])
    target = np.array([network.control[f][0] for f in common])
    if not level and not is_wide(target, 0.0):
        raise StageError(
            "register",
            "the control targets lie on one line, so nothing holds a turn about it",
            "give one off the line",
        )
    rotation, translation = (level_motion if level else rodrigues_motion)(source, target)
    return rotation @ placing.rotations, placing.translations @ rotation.T + translation


def _started(network: Network, placing: _Placing, options: RegisterOptions) -> Start:
    """Features where the majority of the stations sees them."""
    R, t = placing.rotations[network.station], placing.translations[network.station]
    places = np.einsum("nij,nj->ni", R, network.places) + t
    frames = np.array([feature.frame for feature in network.seen]) @ R.transpose(0, 2, 1)
    agrees = np.ones(len(places), dtype=bool)
    feature_places = np.zeros((len(network.names), 3))
    feature_frames = np.tile(np.eye(3), (len(network.names), 1, 1))
    for feature, kind in enumerate(network.kinds):
        rows = np.flatnonzero(network.feature == feature)
        if kind is FeatureKind.POINT:
            majority = largest_cluster(places[rows], options.start_tolerance_m)
        else:
            apart = figures_apart(kind, places[rows], frames[rows, 2])
            majority = _largest(apart < options.start_tolerance_m)
            feature_frames[feature] = frames[rows[majority][0]]
        agrees[rows] = majority
        feature_places[feature] = places[rows[majority]].mean(axis=0)
    state = State(
        rotations=placing.rotations,
        translations=placing.translations,
        places=feature_places,
        frames=feature_frames,
        plumb=np.eye(3),
    )
    return Start(
        state=state,
        agrees=agrees,
        order=tuple(placing.order),
        parents=placing.parents,
        ring=placing.ring,
    )


def largest_cluster(places: Array, tolerance_m: float) -> NDArray[np.bool_]:
    """(n,) which of (n, 3) places belong to the largest group about one of them."""
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    return _largest(apart < tolerance_m)


def _largest(near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    best: NDArray[np.bool_] = near[int(np.argmax(near.sum(axis=1)))]
    return best
