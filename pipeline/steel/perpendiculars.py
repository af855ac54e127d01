"""The paper's node centre: midpoints of the common perpendiculars of a node's rods (section 2.2).

Takes lines (a point and a direction each); gives the midpoints (equations 8 to 13) and the centre made of
them (equation 14 and the text below it).  Leaves out sigmas, which the paper has none of: see nodes.py.

Where it is ill-conditioned, and what is done then:
- Nearly parallel rods (two chords in line through a ball) have no common perpendicular to speak of: equations
  12 and 13 divide by the squared sine of their angle.  Such pairs are left out.
- Equation 14 seeks the point at one distance from all midpoints.  Where the rods do meet, the midpoints are
  one point and its noise, and that sphere's centre may lie anywhere; four midpoints in a plane have none.  It
  is taken only while it lies among the midpoints (no farther from their centroid than the farthest of them),
  else their centroid is taken.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np

from pipeline.core.vocabulary import Array

LEAST_ANGLE_DEG = 10.0
"""Rods at a smaller angle have no common perpendicular."""


class CentreRule(StrEnum):
    """How the centre came from the midpoints."""

    SPHERE = "sphere"
    TRIANGLE = "triangle"
    CENTROID = "centroid"
    NONE = "none"


@dataclass(frozen=True, kw_only=True)
class PerpendicularCentre:
    """A node's centre after the paper.

    Attributes:
        centre: (3,) metres; NaN where no two rods cross.
        rule: that gave it.
        midpoints: how many there are.
        spread_m: root mean square distance of the midpoints from their centroid.
    """

    centre: Array
    rule: CentreRule
    midpoints: int
    spread_m: float


def perpendicular_centre(places: Array, directions: Array) -> PerpendicularCentre:
    """Centre of lines (n, 3) through ``places`` along unit ``directions`` (n, 3), after the paper."""
    pairs = combinations(range(len(places)), 2)
    found = [_midpoint(places[i], directions[i], places[j], directions[j]) for i, j in pairs]
    midpoints = np.array([m for m in found if m is not None]).reshape(-1, 3)
    if not len(midpoints):
        return PerpendicularCentre(
            centre=np.full(3, np.nan), rule=CentreRule.NONE, midpoints=0, spread_m=float("nan")
        )
    centroid = midpoints.mean(axis=0)
    distances = np.linalg.norm(midpoints - centroid, axis=1)
    centre, rule = centroid, CentreRule.CENTROID
    if len(midpoints) % 2:
        centre, rule = _between_lines(centroid, places, directions), CentreRule.TRIANGLE
    elif len(midpoints) >= 4:
        equidistant = _equidistant(midpoints)
        if equidistant is not None and np.linalg.norm(equidistant - centroid) <= distances.max():
            centre, rule = equidistant, CentreRule.SPHERE
    return PerpendicularCentre(
        centre=centre, rule=rule, midpoints=len(midpoints), spread_m=float(np.sqrt(np.mean(distances**2)))
    )


def _midpoint(p: Array, v: Array, q: Array, w: Array) -> Array | None:
    """Midpoint P of the common perpendicular of two lines; None where they are nearly parallel.

    Equations 8 and 9 give the lines as pairs of planes, 10 and 11 their directions v and w, h = v x w; here
    the lines come from fitted cylinders, direction included.  Equation 12 puts P2 - p into the plane of v and
    h, 13 puts P1 - q into the plane of w and h.
    """
    h = np.cross(v, w)
    if np.linalg.norm(h) < np.sin(np.radians(LEAST_ANGLE_DEG)):
        return None
    # det[q + t w - p, v, h] = 0 and det[p + s v - q, w, h] = 0
    t = -np.linalg.det([q - p, v, h]) / np.linalg.det([w, v, h])
    s = -np.linalg.det([p - q, w, h]) / np.linalg.det([v, w, h])
    return np.asarray(0.5 * (p + s * v + q + t * w))


def _equidistant(points: Array) -> Array | None:
    """Equation 14: the point at one distance from all; from more than four points in the mean."""
    first = points[0]
    design = 2 * (points[1:] - first)
    right = np.sum(points[1:] ** 2, axis=1) - first @ first
    solution, _, rank, _ = np.linalg.lstsq(design, right, rcond=1e-6)
    return None if rank < 3 else solution


def _between_lines(centroid: Array, places: Array, directions: Array) -> Array:
    """For an odd number: halfway from the triangle's centroid to its feet on the lines, in the mean."""
    along = np.sum((centroid - places) * directions, axis=1)
    feet = places + along[:, None] * directions
    return np.asarray(0.5 * (centroid + feet.mean(axis=0)))
