"""The map of radii against the true one: bias, noise, coverage, and how straight the measured axis is.

Takes RUN/radius_map.npz (theta_deg (m,), position_m (n,), radius_mm (n, m), NaN where unknown) and the
truth's ``radius_mm``; gives the figures.  Azimuths are those of the cable frame, right-hand rule about +y.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import SurfaceErrors

MOST_CELLS = 200_000
"""Cells that the low orders are fitted to: more say nothing more."""

AZIMUTH_ORDER, POSITION_ORDER = 4, 3
"""Low orders: harmonics around the cable and powers along it, four strips' worth of each."""

BANDS = 12
"""Rings along the cable in which the axis is measured."""

NORMAL_PER_MAD = 1.4826


@dataclass(frozen=True, kw_only=True)
class RadiusMap:
    """Radii on a grid: theta_deg (m,) ascending, position_m (n,) ascending, radius_mm (n, m)."""

    theta_deg: Array
    position_m: Array
    radius_mm: Array


def compare_surface(run_folder: Path, truth: Document) -> SurfaceErrors:
    """Compare the run's map of radii with the truth, cell by cell, where the truth has a value.

    Raises:
        StageError: the map is missing, is no such map, or shares no place with the truth.
    """
    found = _read_map(run_folder / "radius_map.npz")
    radius = truth.inside("radius_mm")
    theta_deg, position_m = radius.array("theta_deg", -1), radius.array("position_m", -1)
    values = radius.array("values", len(position_m), len(theta_deg))
    true = _interpolated(RadiusMap(theta_deg=theta_deg, position_m=position_m, radius_mm=values), found)
    difference = found.radius_mm - true
    known = np.isfinite(difference)
    if not known.any():
        raise StageError(
            "evaluate",
            f"{run_folder / 'radius_map.npz'} shares no place with the truth",
            "give the truth of this survey",
        )
    theta, position, values = _scattered(found, difference, known)
    return SurfaceErrors(
        cells=int(known.sum()),
        coverage_percent=float(100 * known.sum() / np.isfinite(true).sum()),
        bias_mm=float(np.median(difference[known])),
        noise_mm=_noise(theta, position, values),
        within_95_mm=float(np.percentile(np.abs(difference[known]), 95)),
        bow_mm=_bow(theta, position, values),
    )


def _read_map(path: Path) -> RadiusMap:
    try:
        with np.load(path, allow_pickle=False) as archive:
            theta, position, radius = (
                np.asarray(archive[key], dtype=np.float64) for key in ("theta_deg", "position_m", "radius_mm")
            )
    except FileNotFoundError as error:
        raise StageError("evaluate", f"{path} is missing", "run the survey to its end") from error
    except (OSError, ValueError, KeyError) as error:
        raise StageError("evaluate", f"{path} is no map of radii", "run the survey again") from error
    if radius.shape != (len(position), len(theta)):
        raise StageError(
            "evaluate", f"{path}: radius_mm has the shape {radius.shape}", "run the survey again"
        )
    return RadiusMap(theta_deg=theta, position_m=position, radius_mm=radius)


def _interpolated(true: RadiusMap, places: RadiusMap) -> Array:
    """True radii at the cells of another map, bilinear and closed around the cable; NaN beyond the ends."""
    order = np.argsort(true.theta_deg % 360)
    theta = true.theta_deg[order] % 360
    values = true.radius_mm[:, order]
    # one column more on each side closes the ring
    theta = np.concatenate([theta[-1:] - 360, theta, theta[:1] + 360])
    values = np.hstack([values[:, -1:], values, values[:, :1]])
    at = RegularGridInterpolator((true.position_m, theta), values, bounds_error=False, fill_value=np.nan)
    position, azimuth = np.meshgrid(places.position_m, places.theta_deg % 360, indexing="ij")
    return np.asarray(at((position, azimuth)), dtype=np.float64)


def _scattered(places: RadiusMap, difference: Array, known: Array) -> tuple[Array, Array, Array]:
    """Azimuth in radians, position from -1 to 1 over the map, difference: (k,) each, every so many cells."""
    position, theta = np.meshgrid(places.position_m, np.radians(places.theta_deg), indexing="ij")
    cells = np.flatnonzero(known)
    cells = cells[:: 1 + len(cells) // MOST_CELLS]
    first, last = places.position_m[0], places.position_m[-1]
    scaled = 2 * (position - first) / max(last - first, 1e-12) - 1
    return theta.ravel()[cells], scaled.ravel()[cells], difference.ravel()[cells]


def _noise(theta: Array, position: Array, values: Array) -> float:
    harmonics = [np.ones_like(theta)]
    for order in range(1, AZIMUTH_ORDER + 1):
        harmonics += [np.cos(order * theta), np.sin(order * theta)]
    powers = np.polynomial.legendre.legvander(position, POSITION_ORDER).T
    design = np.stack([harmonic * power for harmonic in harmonics for power in powers], axis=1)
    keep = np.ones(len(values), dtype=bool)
    residual = values
    # fitted again without what stands out: a few wild cells must not tilt the low orders
    for _ in range(3):
        solution, *_ = np.linalg.lstsq(design[keep], values[keep], rcond=1e-9)
        residual = values - design @ solution
        keep = np.abs(residual) <= 4 * max(_robust_sigma(residual), 1e-12)
    return _robust_sigma(residual)


def _bow(theta: Array, position: Array, values: Array) -> float:
    """Largest distance from its own straight line of the axis that the differences imply, mm."""
    offsets, middles = [], []
    edges = np.linspace(-1, 1, BANDS + 1)
    for low, high in pairwise(edges):
        inside = (position >= low) & (position <= high)
        if len(np.unique(np.floor(theta[inside] % (2 * np.pi) / (np.pi / 4)))) < 8:
            continue  # the centre of an arc is not the axis
        t, v = theta[inside], values[inside]
        design = np.stack([np.ones_like(t), np.cos(t), -np.sin(t)], axis=1)
        middle = np.median(v)
        near = np.abs(v - middle) <= 6 * max(_robust_sigma(v), 1e-12)
        offsets.append(np.linalg.lstsq(design[near], v[near], rcond=None)[0][1:])
        middles.append(float(np.mean(position[inside])))
    if len(offsets) < 3:
        return float("nan")
    line = np.polynomial.polynomial.polyfit(middles, np.array(offsets), 1)
    straight = np.polynomial.polynomial.polyval(np.array(middles), line).T
    return float(np.max(np.linalg.norm(np.array(offsets) - straight, axis=1)))


def _robust_sigma(values: Array) -> float:
    return float(NORMAL_PER_MAD * np.median(np.abs(values - np.median(values))))
