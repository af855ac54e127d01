"""Fitted rods and balls of a run against those that are there, matched by place."""

from collections import Counter

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import places_of, rms
from pipeline.evaluate.steel.structure_errors import MemberErrors

TURN = 0.035
"""Sine of the angle that a find's axis may make with the true one: 2 degrees."""
REACH_M = 0.05


def compare_cylinders(members: Document, key: str, truth: Document, true_key: str) -> MemberErrors:
    """Rods: a find belongs to the true rod whose axis both its ends lie nearest to, within REACH_M."""
    true, found = list(truth.items(true_key)), list(members.items(key))
    starts = places_of(true, "start_m")
    ends = places_of(true, "end_m")
    owners, places, radii = [], [], []
    for row in found:
        first, last = row.array("start_m", 3), row.array("end_m", 3)
        owner, away = _nearest_axis(starts, ends, first, last)
        if owner < 0:
            continue
        owners.append(owner)
        places.append(1000 * away)
        radii.append(row.number("radius_mm") - true[owner].number("radius_mm"))
    return _told(len(true), len(found), owners, places, radii)


def compare_balls(members: Document, truth: Document) -> MemberErrors:
    """Balls: a find belongs to the nearest true ball within REACH_M."""
    true, found = list(truth.items("nodes")), list(members.items("balls"))
    centres = places_of(true, "ball_m")
    owners, places, radii = [], [], []
    for row in found:
        apart = np.linalg.norm(centres - row.array("centre_m", 3), axis=1)
        owner = int(np.argmin(apart)) if len(apart) else -1
        if owner < 0 or apart[owner] > REACH_M:
            continue
        owners.append(owner)
        places.append(1000 * float(apart[owner]))
        radii.append(row.number("radius_mm") - true[owner].number("radius_mm"))
    return _told(len(true), len(found), owners, places, radii)


def _nearest_axis(starts: Array, ends: Array, first: Array, last: Array) -> tuple[int, float]:
    """Number of the true axis that a find lies on, -1 for none, and its ends' rms distance from it, m."""
    length = np.linalg.norm(ends - starts, axis=1)
    axes = (ends - starts) / length[:, None]
    off, inside = [], []
    for place in (first, last):
        away = place - starts
        along = np.sum(away * axes, axis=1)
        off.append(np.linalg.norm(away - along[:, None] * axes, axis=1))
        inside.append(along)
    middle = (inside[0] + inside[1]) / 2
    apart = np.sqrt((off[0] ** 2 + off[1] ** 2) / 2)
    own = (last - first) / max(float(np.linalg.norm(last - first)), 1e-9)
    straight = np.linalg.norm(np.cross(axes, own), axis=1) < TURN
    fits = straight & (middle > 0) & (middle < length) & (apart < REACH_M)
    if not fits.any():
        return -1, float("nan")
    owner = int(np.argmin(np.where(fits, apart, np.inf)))
    return owner, float(apart[owner])


def _told(true: int, found: int, owners: list[int], places: list[float], radii: list[float]) -> MemberErrors:
    times = Counter(owners)
    return MemberErrors(
        true=true,
        found=len(times),
        doubled=sum(times.values()) - len(times),
        false=found - len(owners),
        place_rms_mm=rms(places),
        radius_rms_mm=rms(radii),
        radius_bias_mm=float(np.median(radii)) if radii else float("nan"),
    )
