"""When each row of a frame sees the light: motion blur and rolling shutter as short exposures; pure.

Takes the specification, gives moments, in frame intervals about the moment of the frame, which is that of
the image's middle row half-way through its exposure.  Leaves out how a moment is rendered.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from synth.spec import Spec

BLUR_MOMENTS = 8
BLUR_MOMENTS_OF_A_STRIPE = 4  # every stripe is a render of its own
STRIPES = 12


@dataclass(frozen=True, kw_only=True)
class Exposure:
    """A short exposure of some rows.

    Attributes:
        shift: its moment, in frame intervals after the moment of the frame.
        rows: first row and the one after the last; None is the whole picture.
        weight: share of the light of these rows.
    """

    shift: float
    rows: tuple[int, int] | None
    weight: float


def exposures(spec: Spec, *, blurred: bool = True) -> tuple[Exposure, ...]:
    """The exposures that add up to a frame; ``blurred = False`` shuts the shutter at once (for depth)."""
    stripes = _stripes(spec)
    blur = _blur(spec, len(stripes)) if blurred else [0.0]
    return tuple(
        Exposure(shift=read_at + within, rows=rows, weight=1.0 / len(blur))
        for rows, read_at in stripes
        for within in blur
    )


def _stripes(spec: Spec) -> list[tuple[tuple[int, int] | None, float]]:
    """Rows that are read as one, and the moment of their middle; read from the top of the image."""
    share, height = spec.sensor.readout_share, spec.lens.height_px
    if share == 0.0:
        return [(None, 0.0)]
    edges = np.unique(np.rint(np.linspace(0, height, STRIPES + 1)).astype(int)).tolist()
    return [((a, b), share * ((a + b) / (2.0 * height) - 0.5)) for a, b in itertools.pairwise(edges)]


def _blur(spec: Spec, stripes: int) -> list[float]:
    """Moments within the open shutter, about its middle."""
    if spec.sensor.motion_blur_mm == 0.0:
        return [0.0]
    count = BLUR_MOMENTS if stripes == 1 else BLUR_MOMENTS_OF_A_STRIPE
    open_for = spec.sensor.motion_blur_mm / 1000.0 * (spec.robot.frames - 1) / spec.robot.travel_m
    return [open_for * ((i + 0.5) / count - 0.5) for i in range(count)]
