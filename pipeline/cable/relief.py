"""What stands proud of the sheath or is dented: the base surface, and every feature with its height.

Takes the ring's map of radii; gives the base section all along the cable, the map of heights over it (the
relief), and the features in it: ridges, bulges, dents.  The base is in :mod:`pipeline.cable.relief_base`, the
kinds of features in :mod:`pipeline.cable.relief_ridges` and :mod:`pipeline.cable.relief_spots`.
"""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.relief_base import BaseSection, fit_base
from pipeline.cable.relief_map import HeightMap, noise_of_rows, smoothed
from pipeline.cable.relief_ridges import Ridge, find_ridges
from pipeline.cable.relief_spots import Spot, find_spots
from pipeline.core.vocabulary import Array

_NOISE_MM = 20.0  # length of cable over which the map's noise is taken as the same


class ReliefKind(StrEnum):
    """What a feature is."""

    BULGE = "bulge"
    DENT = "dent"
    RIDGE = "ridge"


@dataclass(frozen=True, kw_only=True)
class ReliefOptions:
    """What counts as standing out.

    Attributes:
        least_height_mm: of a feature; lower ones are left alone.
        noise_factor: a feature exceeds the smoothed map's noise so many times.
        least_area_mm2: of a bulge or dent.
        smooth_mm: standard deviation of the Gaussian that features are looked for through.
        knots_mm: the base section bends along the cable over lengths like this.
        widest_window_mm: where the surface was matched in wider windows, relief is not looked for: they
            flatten it, and their noise looks like it.
        seed: of the samples that start the base section.
    """

    least_height_mm: float = field(default=0.2, metadata={"above": 0.0})
    noise_factor: float = field(default=8.0, metadata={"above": 0.0})
    least_area_mm2: float = field(default=40.0, metadata={"above": 0.0})
    smooth_mm: float = field(default=1.5, metadata={"above": 0.0})
    knots_mm: float = field(default=18.0, metadata={"above": 0.0})
    widest_window_mm: float = field(default=8.0, metadata={"above": 0.0})
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Feature:
    """One feature of the relief.

    Attributes:
        kind: see there.
        height_mm: over the base, of a dent below it; positive.
        sigma_mm: its standard deviation.
        position_m: along the cable, of its middle; of a ridge, of the point nearest the middle of the travel.
        azimuth_deg: of that point, -180 to 180.
        length_mm: along the cable.
        width_mm: around the cable; of a ridge, across it at right angles.
        pitch_m: of a ridge, length of a whole turn, positive where the azimuth grows along the cable; NaN for
            the others and where a ridge runs straight along.
    """

    kind: ReliefKind
    height_mm: float
    sigma_mm: float
    position_m: float
    azimuth_deg: float
    length_mm: float
    width_mm: float
    pitch_m: float


@dataclass(frozen=True, kw_only=True)
class Relief:
    """The base and what stands out of it.

    Attributes:
        y_m: (n,) metres, rows of the map.
        azimuth: (m,) radians, columns of the map, about the base's centre.
        base_diameter_mm: (n,) mean diameter of the base section; NaN where too little was seen.
        base_noise_mm: (n,) its standard deviation from the map's noise alone.
        height_mm: (n, m) float32, heights over the base; NaN where not measured.
        level_mm: what stands out exceeds this, at the median row.
        features: the largest first, ridges before the others.
    """

    y_m: Array
    azimuth: Array
    base_diameter_mm: Array
    base_noise_mm: Array
    height_mm: NDArray[np.float32]
    level_mm: float
    features: tuple[Feature, ...]


def find_relief(
    azimuth: Array,
    y_m: Array,
    radius_mm: Array,
    travel_m: float,
    window_mm: float,
    options: ReliefOptions,
) -> Relief:
    """Fit the base and measure what stands out of it.

    Args:
        azimuth: (m,) radians, evenly spaced, the full turn.
        y_m: (n,) metres, evenly spaced.
        radius_mm: (n, m) about the straight axis, NaN where not measured.
        travel_m: the middle of it is where ridges are named.
        window_mm: side of the window that the map was matched with: noise is alike over it.
        options: see there.
    """
    base = fit_base(azimuth, y_m, radius_mm, options.knots_mm, options.seed)
    heights = base.heights_mm(azimuth, radius_mm)
    features: tuple[Feature, ...] = ()
    level = np.full(len(y_m), np.nan)
    if np.isfinite(base.radius_mm).any() and window_mm <= options.widest_window_mm:
        relief_map = HeightMap(
            azimuth=azimuth,
            y_mm=1000 * y_m,
            height_mm=heights,
            radius_mm=float(np.mean(base.radius_mm)),
            wave_mm=base.wave_mm,
        )
        smooth = smoothed(relief_map, options.smooth_mm)
        rows = max(round(_NOISE_MM / relief_map.cell_mm[0]), 1)
        level = np.maximum(options.noise_factor * noise_of_rows(smooth, rows), options.least_height_mm)
        ridges, taken = find_ridges(relief_map, smooth, level, window_mm)
        spots = find_spots(relief_map, smooth, level, taken, options.least_area_mm2, window_mm)
        features = tuple(_ridge(r, base, travel_m) for r in ridges) + tuple(_spot(s, base) for s in spots)
    return Relief(
        y_m=y_m,
        azimuth=azimuth,
        base_diameter_mm=2 * base.radius_mm,
        base_noise_mm=2 * base.sigma_mm,
        height_mm=heights.astype(np.float32),
        level_mm=float(np.median(level)),
        features=tuple(f for f in features if f.height_mm >= options.least_height_mm),
    )


def _ridge(ridge: Ridge, base: BaseSection, travel_m: float) -> Feature:
    middle_mm = 500 * travel_m
    turn_per_mm = float(ridge.crest[1])
    turns = turn_per_mm * 1000 * float(np.ptp(base.y_m)) / (2 * np.pi)
    return Feature(
        kind=ReliefKind.RIDGE,
        height_mm=ridge.height_mm,
        sigma_mm=_with_base(ridge.sigma_mm, base, middle_mm),
        position_m=middle_mm / 1000,
        azimuth_deg=_azimuth_deg(float(ridge.azimuth(middle_mm))),
        length_mm=ridge.length_mm,
        width_mm=ridge.width_mm,
        pitch_m=2 * np.pi / turn_per_mm / 1000 if abs(turns) > 0.01 else float("nan"),
    )


def _spot(spot: Spot, base: BaseSection) -> Feature:
    return Feature(
        kind=ReliefKind.BULGE if spot.height_mm > 0 else ReliefKind.DENT,
        height_mm=abs(spot.height_mm),
        sigma_mm=_with_base(spot.sigma_mm, base, spot.y_mm),
        position_m=spot.y_mm / 1000,
        azimuth_deg=_azimuth_deg(spot.azimuth),
        length_mm=spot.length_mm,
        width_mm=spot.width_mm,
        pitch_m=float("nan"),
    )


def _with_base(sigma_mm: float, base: BaseSection, y_mm: float) -> float:
    return float(np.hypot(sigma_mm, np.interp(y_mm, 1000 * base.y_m, base.sigma_mm)))


def _azimuth_deg(azimuth: float) -> float:
    return float(np.rad2deg(np.angle(np.exp(1j * azimuth))))
