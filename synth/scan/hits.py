"""Where rays from the origin meet surfaces, exactly: one surface against many unit directions.

Every function takes a surface in the station's frame and directions (..., 3) of unit length, and gives
``Hit``: the range (...), inf where missed; how far inside the surface's outline the ray passes, metres,
negative outside (which tells beams that graze an edge); and the cosine of the incidence.
Formulas: elementary (Ericson, Real-Time Collision Detection, 2005, sections 5.3.1, 5.3.2 and 5.3.7).
"""

from typing import NamedTuple

import numpy as np

from pipeline.core.vocabulary import Array

TINY = 1e-300


class Hit(NamedTuple):
    """Range, inside margin (both metres) and cosine of incidence, each of the directions' shape."""

    range_m: Array
    inside_m: Array
    cosine: Array


def hit_sphere(sphere: Array, directions: Array) -> Hit:
    """Sphere (4,): centre, radius."""
    centre, radius = sphere[:3], sphere[3]
    along = directions @ centre
    off = centre - along[..., None] * directions
    off2 = np.einsum("...i,...i->...", off, off)
    half = np.sqrt(np.maximum(radius**2 - off2, 0.0))
    ahead = along > 0.0
    met = ahead & (off2 <= radius**2)
    inside = np.where(ahead, radius - np.sqrt(off2), -np.inf)
    return Hit(np.where(met, along - half, np.inf), inside, half / radius)


def hit_cylinder(cylinder: Array, directions: Array) -> Hit:
    """Lateral surface of a cylinder (7,): start, end, radius; from outside."""
    start, radius = cylinder[:3], cylinder[6]
    length = float(np.linalg.norm(cylinder[3:6] - start))
    axis = (cylinder[3:6] - start) / length
    start_along = float(start @ axis)
    start_off = start - start_along * axis
    along = directions @ axis
    # the ray in the plane across the axis: t * across, at angles near the axis across is small
    across2 = np.maximum(1.0 - along**2, TINY)
    towards = directions @ start_off
    # distance of the two lines: of start_off from the direction across
    off2 = np.maximum(float(start_off @ start_off) - towards**2 / across2, 0.0)
    half = np.sqrt(np.maximum(radius**2 - off2, 0.0) / across2)
    range_m = towards / across2 - half
    place = range_m * along - start_along
    ahead = towards > 0.0
    met = ahead & (off2 <= radius**2) & (place >= 0.0) & (place <= length)
    near = towards / across2 * along - start_along
    beside = np.maximum(np.maximum(-near, near - length), 0.0)  # beyond its ends nothing grazes
    inside = np.where(ahead & (beside <= 2.0 * radius), radius - np.sqrt(off2), -np.inf)
    cosine = half * across2 / radius
    return Hit(np.where(met, range_m, np.inf), inside, cosine)


def hit_rectangle(rectangle: Array, directions: Array) -> Hit:
    """Rectangle (9,): corner, edge, edge; from both sides."""
    corner, u, v = rectangle[:3], rectangle[3:6], rectangle[6:]
    long_u, long_v = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    normal = np.cross(u, v) / (long_u * long_v)
    falling = directions @ normal
    falling = np.where(np.abs(falling) < 1e-12, 1e-12, falling)
    range_m = float(corner @ normal) / falling
    # coordinates along the edges, metres
    a = range_m * (directions @ (u / long_u)) - float(corner @ u) / long_u
    b = range_m * (directions @ (v / long_v)) - float(corner @ v) / long_v
    inside = np.minimum(np.minimum(a, long_u - a), np.minimum(b, long_v - b))
    met = (range_m > 0.0) & (inside >= 0.0)
    cosine = np.abs(falling)
    inside = np.where(range_m > 0.0, inside * cosine, -np.inf)
    return Hit(np.where(met, range_m, np.inf), inside, cosine)


def hit_disc(disc: Array, directions: Array) -> Hit:
    """Disc (7,): centre, unit normal, radius; from both sides."""
    centre, normal, radius = disc[:3], disc[3:6], disc[6]
    falling = directions @ normal
    falling = np.where(np.abs(falling) < 1e-12, 1e-12, falling)
    range_m = float(centre @ normal) / falling
    off = range_m[..., None] * directions - centre
    inside = radius - np.sqrt(np.einsum("...i,...i->...", off, off))
    met = (range_m > 0.0) & (inside >= 0.0)
    cosine = np.abs(falling)
    return Hit(np.where(met, range_m, np.inf), np.where(range_m > 0.0, inside * cosine, -np.inf), cosine)


HIT = {"sphere": hit_sphere, "cylinder": hit_cylinder, "rectangle": hit_rectangle, "disc": hit_disc}
