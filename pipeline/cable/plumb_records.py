"""The records of the plumb-line fit: what goes in and what comes out of :mod:`pipeline.cable.plumb_lines`."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class PlumbLineOptions:
    """What is taken for granted about the cable's shape.

    Attributes:
        shape_sigma_mm: standard deviation of the cable's diameter, and of its axis across, about the mean.
            Raised by the fit where the edges show more.
        shortest_wave_m, longest_wave_m: range of wavelengths of that variation along the cable; its variance
            is spread evenly over the logarithm of the wavelength.  Waves longer than the cable that was seen
            matter most: a picture cannot tell half of one from the lens.
        patch_mm: errors of edge points closer than this on the cable are taken as dependent (dirt at the
            edge deceives all frames in the same way).
    """

    shape_sigma_mm: float = field(default=0.3, metadata={"above": 0.0})
    shortest_wave_m: float = field(default=0.1, metadata={"above": 0.0})
    longest_wave_m: float = field(default=2.0, metadata={"above": 0.0})
    patch_mm: float = field(default=15.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class PlumbScene:
    """Where the camera stands, roughly; a few per cent are good enough.

    Attributes:
        half_diagonal_px: half of the picture's diagonal.
        focal_px: focal length.
        standoff_m: projection centre to cable axis.
        positions_m: (n,) place of each frame along the cable.
        forward: +1 where the travel points along the picture's x (right, down), -1 where against it.
    """

    half_diagonal_px: float
    focal_px: float
    standoff_m: float
    positions_m: Array
    forward: int


@dataclass(frozen=True, kw_only=True)
class PlumbEdges:
    """Edge points of all frames, cable along x, relative to the principal point, pixels.

    Attributes:
        points_px: (n, 2).
        frame: (n,) index into the frames.
        side: (n,) -1 on the first edge (smaller y), +1 on the second.
    """

    points_px: Array
    frame: NDArray[np.int64]
    side: NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class PlumbLineFit:
    """Lambda and what stands behind it.

    Attributes:
        lambda_half_diagonal: lambda for radii in half-diagonals.
        sigma: its standard deviation.
        start_lambda: the algebraic starting value.
        line_count, point_count: edges and points used.
        bent_px, straight_px: root mean square distance from a straight line per edge, before and after the
            correction; what is left after it is noise and the cable's own shape.
        noise_px: standard deviation of an edge point.
        shape_sigma_mm: standard deviation of the shape's prior that the data agreed with.
    """

    lambda_half_diagonal: float
    sigma: float
    start_lambda: float
    line_count: int
    point_count: int
    bent_px: float
    straight_px: float
    noise_px: float
    shape_sigma_mm: float
