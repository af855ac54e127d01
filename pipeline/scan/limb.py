"""Which points of a scanned cable were met at its limb, where beams see what is behind it as well.

Takes the points of one scan on a cable, and the cable's axis; tells which to keep.  The scanner's place is
not needed: it looks at a straight cable from the same side all along, and where it looks at it squarely the
points lie closest, falling off as the cosine of the angle from there, whatever else hides parts of it.
Leaves scans alone that saw the cable from several sides: nobody knows then which point belongs to which.

A beam that passes the limb nearer than its own radius is partly reflected by what is behind and reads too
far, or meets nothing and is lost; what comes back of rays that pass outside the cable lies outside it.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.scan.tube import FoundCable

FARTHEST_DEG = 75.0
"""Points farther around from the middle of what was seen are left out: from here on a beam of 2 mm radius
reaches the limb of a cable of 110 mm."""
BEHIND_DEG, BEHIND_SHARE = 100.0, 0.02
"""More than this share of the points farther around than this: seen from several sides."""
BINS, FILLED = 72, 0.05
"""Of the circumference; those that hold less than this share of the fullest count as not seen."""
ON_SURFACE = 0.1
"""Share of the radius that a point on the cable may lie off."""


def off_limb(points: Array, cable: FoundCable) -> NDArray[np.bool_]:
    """(n,) which of one scan's points (n, 3) to keep; those off the cable count like those beside them."""
    if not len(points):
        return np.ones(0, dtype=bool)
    across = np.linalg.svd(cable.direction[None])[2][1:]
    away = (points - cable.place) @ across.T
    size = np.hypot(*away.T)
    on = np.abs(size - cable.radius_m) < ON_SURFACE * cable.radius_m
    turn = np.arctan2(away[:, 1], away[:, 0])
    middle = _facing(turn[on])
    aside = np.abs(np.angle(np.exp(1j * (turn - middle))))
    if not on.any() or np.mean(aside[on] > np.radians(BEHIND_DEG)) > BEHIND_SHARE:
        return np.ones(len(points), dtype=bool)
    return np.asarray(aside < np.radians(FARTHEST_DEG))


def _facing(turn: Array) -> float:
    """Azimuth of the scanner, radians, from those of the points (n,): where they lie closest."""
    bins = np.floor(turn / (2 * np.pi) * BINS).astype(np.int64) % BINS
    count = np.bincount(bins, minlength=BINS)
    seen = np.flatnonzero(count > FILLED * float(np.max(count)))
    at = 2 * np.pi * (seen + 0.5) / BINS
    waves = np.column_stack([np.cos(at), np.sin(at)])
    x, y = np.linalg.lstsq(waves, count[seen].astype(float), rcond=None)[0]
    return float(np.arctan2(y, x))
