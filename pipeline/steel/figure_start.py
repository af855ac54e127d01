"""A station placed on the axes and planes that it shares, where its targets alone do not hold it.

Takes common points, axes and planes in both frames; gives the rigid motion, as a starting value.  Directions
give the rotation (the closest one, Kabsch 1976, "A solution for the best rotation to relate two sets of
vectors"), then places give the translation by linear least squares.  An axis may be told either way round, so
every combination is tried, and only a motion that is alone in fitting is given.  Leaves out gross errors
among them: what does not fit together places nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from pipeline.core.rotations import angle_between_deg
from pipeline.core.vocabulary import Array
from pipeline.steel.network import Network
from pipeline.steel.records import FeatureKind

TURNED_DEG = 3.0
"""Sightings of one axis or plane, or a station's directions, differ by this at most."""
LEAST_SPREAD = 0.1
"""Directions must differ, and places be held each way, by this part of what is held best."""
MOST_AXES = 6
"""Axes whose ends are tried both ways; further ones are only checked."""
MOST_LINKED, LEAST_LINK_M = 12, 0.5
"""Of so many points and axes the ways between them are directions as well, if they are so long."""
PARALLEL = 0.1
"""Axes whose directions differ by less count as parallel."""
LEVEL_WEIGHT = 100.0
"""A plumb axis is known to seconds, a figure's direction to minutes."""


@dataclass(frozen=True, kw_only=True)
class Common:
    """A thing in two frames: its kind, and place (3,) and direction (3,) in each; no directions of points."""

    kind: FeatureKind
    source: Array
    source_direction: Array
    target: Array
    target_direction: Array


def common_with(
    network: Network,
    station: int,
    points: Mapping[int, int],
    places: Mapping[int, Sequence[Array]],
    figures: Mapping[int, tuple[Array, Array]],
) -> list[Common]:
    """What a station shares with those placed: its own as source, theirs as target.

    Args:
        network: who sees what.
        station: its number.
        points: feature number to observation number of the points that it sees.
        places: feature number to sightings (3,) of the points that are placed.
        figures: feature number to place and direction of the axes and planes that are.
    """
    none = np.zeros(3)
    shared = [
        (points[f], np.asarray(np.mean(places[f], axis=0)), none) for f in sorted(places.keys() & points)
    ]
    for number in network.figures_of(station):
        feature = int(network.feature[number])
        if feature in figures:
            shared.append((number, *figures[feature]))
    return [
        Common(
            kind=network.seen[number].kind,
            source=network.seen[number].place,
            source_direction=network.seen[number].direction,
            target=place,
            target_direction=direction,
        )
        for number, place, direction in shared
    ]


def figure_motion(common: Sequence[Common], tolerance_m: float, *, level: bool) -> tuple[Array, Array] | None:
    """Rotation (3, 3) and translation (3,), target = rotation source + translation; None where nothing or
    more than one motion fits.

    Args:
        common: what both frames show.
        tolerance_m: how far a thing may lie off and still fit.
        level: both z axes are plumb.
    """
    axes = [one for one in common if one.kind is FeatureKind.LINE][:MOST_AXES]
    sure = _sure_directions(common, level)
    found: list[tuple[Array, Array]] = []
    for signs in product((1.0, -1.0), repeat=len(axes)):
        told = [(a.source_direction, s * a.target_direction, 1.0) for a, s in zip(axes, signs, strict=True)]
        rotation = _rotation([*sure, *told])
        if rotation is None:
            return None  # whichever way the axes point, a turn is left open
        translation = _translation(common, rotation)
        if translation is None:
            return None
        if not _fits(common, rotation, translation, tolerance_m):
            continue
        if all(angle_between_deg(rotation, other) > TURNED_DEG for other, _ in found):
            found.append((rotation, translation))
    return found[0] if len(found) == 1 else None


def figures_apart(kind: FeatureKind, places: Array, directions: Array) -> Array:
    """(n, n) metres: how far places (n, 3) lie off one another's axes or planes; infinite where turned."""
    away = places[None] - places[:, None]
    along = np.abs(np.einsum("ijk,ik->ij", away, directions))
    off = along
    if kind is FeatureKind.LINE:
        off = np.sqrt(np.maximum(np.sum(away**2, axis=2) - along**2, 0))
    turned = np.abs(directions @ directions.T) < np.cos(np.radians(TURNED_DEG))
    return np.where(turned, np.inf, np.maximum(off, off.T))


def _sure_directions(common: Sequence[Common], level: bool) -> list[tuple[Array, Array, float]]:
    """Source, target, weight of directions whose sign is known: plumb lines, normals, ways between things."""
    up = np.array([0.0, 0.0, 1.0])
    sure = [(up, up, LEVEL_WEIGHT)] if level else []
    sure += [(c.source_direction, c.target_direction, 1.0) for c in common if c.kind is FeatureKind.PLANE]
    things = [c for c in common if c.kind is not FeatureKind.PLANE][:MOST_LINKED]
    for first, second in combinations(things, 2):
        before = _link(first.source, first.source_direction, second.source, second.source_direction)
        after = _link(first.target, first.target_direction, second.target, second.target_direction)
        lengths = float(np.linalg.norm(before)), float(np.linalg.norm(after))
        if min(lengths) > LEAST_LINK_M:
            sure.append((before / lengths[0], after / lengths[1], 1.0))
    return sure


def _link(first: Array, along: Array, second: Array, beside: Array) -> Array:
    """(3,) the shortest way from one point or axis to another; nearly parallel axes count as parallel."""
    ways, sizes, _ = np.linalg.svd(np.stack([along, beside], axis=1), full_matrices=False)
    ways = ways[:, sizes > PARALLEL * max(sizes[0], 1e-9)]
    away = second - first
    return np.asarray(away - ways @ (ways.T @ away))


def _rotation(directions: Sequence[tuple[Array, Array, float]]) -> Array | None:
    """The rotation that turns sources closest to targets; None where they are all parallel."""
    if len(directions) < 2:
        return None
    spread = np.linalg.svd(np.array([source for source, _, _ in directions]), compute_uv=False)
    if spread[1] < LEAST_SPREAD * spread[0]:
        return None
    moment = sum((w * np.outer(target, source) for source, target, w in directions), np.zeros((3, 3)))
    left, _, right = np.linalg.svd(moment)
    rotation: Array = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return rotation


def _translation(common: Sequence[Common], rotation: Array) -> Array | None:
    """The translation that brings places onto points, axes and planes; None where one way is left open."""
    rows = np.concatenate([_across(one) for one in common])
    right = np.concatenate([_across(one) @ (one.target - rotation @ one.source) for one in common])
    held = np.linalg.svd(rows, compute_uv=False)
    if len(held) < 3 or held[2] < LEAST_SPREAD * held[0]:
        return None
    solution: Array = np.linalg.lstsq(rows, right, rcond=None)[0]
    return solution


def _across(one: Common) -> Array:
    """(k, 3) the ways in which a thing holds a place: all, across an axis, along a normal."""
    if one.kind is FeatureKind.POINT:
        return np.eye(3)
    if one.kind is FeatureKind.PLANE:
        return one.target_direction[None]
    return np.eye(3) - np.outer(one.target_direction, one.target_direction)


def _fits(common: Sequence[Common], rotation: Array, translation: Array, tolerance_m: float) -> bool:
    limit = np.cos(np.radians(TURNED_DEG))
    for one in common:
        off = _across(one) @ (rotation @ one.source + translation - one.target)
        if np.linalg.norm(off) > tolerance_m:
            return False
        cosine = float(one.target_direction @ rotation @ one.source_direction)
        if one.kind is FeatureKind.LINE and abs(cosine) < limit:
            return False
        if one.kind is FeatureKind.PLANE and cosine < limit:
            return False
    return True
