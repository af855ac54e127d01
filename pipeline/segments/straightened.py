"""A segment's surface laid along its axis: heights about where the axis is, not about the line through it.

Takes a segment's :class:`~pipeline.cable.ring.Ring`, which is about the straight line that fits its axis
best, and the axis; gives the ring with radii about the axis.  So a bent cable, joined of straight pieces, has
no steps where they meet: the model is straight all along, and the curve of the axis is told beside it.
"""

from dataclasses import replace

import numpy as np

from pipeline.cable.ring import Ring
from pipeline.core.vocabulary import Array

DEGREE = 4
"""Of the polynomial that smooths the axis: a single section's centre is a matter of noise."""
LEAST_PLACES = 4 * DEGREE
"""Fewer places of the axis do not bear the polynomial."""


def straightened(ring: Ring, y_m: Array, centre_mm: Array) -> Ring:
    """The surface about its axis.

    Args:
        ring: of the segment.
        y_m, centre_mm: (n,) places and (n, 2) x and z of its axis there, in the ring's frame; where they are
            too few the ring stays as it is.
    """
    if len(y_m) < LEAST_PLACES:
        return ring
    at = np.clip(ring.y_m, y_m.min(), y_m.max())
    x_m, z_m = (
        np.polynomial.Polynomial.fit(y_m, across / 1000, DEGREE)(at)[:, None] for across in centre_mm.T
    )
    # a surface point lies at r (cos a, -sin a) from the line; to first order in the bow it loses its share
    towards = x_m * np.cos(ring.azimuth) - z_m * np.sin(ring.azimuth)
    return replace(ring, radius_m=(ring.radius_m - towards).astype(ring.radius_m.dtype))
