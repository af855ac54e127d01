"""The map of radii against the true one: bias, noise, coverage, and whether what is told as seen is right.

Takes RUN/radius_map.npz (theta_deg (m,), position_m (n,), radius_mm (n, m), NaN where unknown) and the
truth's ``radius_mm``; gives the figures.  Azimuths are those of the cable frame, right-hand rule about +y.

The truth's radii are about the true, perhaps bowed, axis; the run's about the y axis of its own frame.  So
every cell of the run is taken as a point, and the true axis is sought in the run's frame as the smooth curve
about which the run's surface differs from the truth by no first harmonic (an eccentricity) anywhere along
the cable; radius and azimuth of the point about this curve are what is compared.  How well the run itself
found the axis is told apart, in :mod:`pipeline.evaluate.axis`.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import StationCoverage, SurfaceErrors

MOST_CELLS = 200_000
"""Cells that axis and low orders are fitted to: more say nothing more."""

AZIMUTH_ORDER, POSITION_ORDER = 4, 3
"""Low orders: harmonics around the cable and powers along it, four strips' worth of each."""

AXIS_ORDER, AXIS_ROUNDS = 4, 5
"""Powers along the cable that the true axis is sought with, and how often that is refined."""

LEAST_OCTANTS = 6
"""A surface seen over less of the girth does not say where its axis is: it is compared as it stands."""

WRONG_MM = 0.5
"""A radius farther off than this was not seen, whatever the run says."""

STATION_MM, BIN_DEG = 10.0, 1.0
"""Length of cable and width of the bins by which the coverage of a station is judged."""

NORMAL_PER_MAD = 1.4826

SPARE = 4
"""Columns repeated on either side of the truth's turn, so that a spline is smooth across its seam."""


@dataclass(frozen=True, kw_only=True)
class RadiusMap:
    """Radii on a grid: theta_deg (m,) ascending, position_m (n,) ascending, radius_mm (n, m)."""

    theta_deg: Array
    position_m: Array
    radius_mm: Array


def compare_surface(run_folder: Path, report: Document, truth: Document) -> SurfaceErrors:
    """Compare the run's map of radii with the truth, cell by cell, where the truth has a value.

    Raises:
        StageError: the map is missing, is no such map, or shares no place with the truth.
    """
    found = _read_map(run_folder / "radius_map.npz")
    true = _read_truth(truth)
    covered = (found.position_m >= true.position_m[0]) & (found.position_m <= true.position_m[-1])
    found = RadiusMap(
        theta_deg=found.theta_deg, position_m=found.position_m[covered], radius_mm=found.radius_mm[covered]
    )
    known = np.isfinite(found.radius_mm)
    if not known.any():
        raise StageError(
            "evaluate",
            f"{run_folder / 'radius_map.npz'} shares no place with the truth",
            "give the truth of this survey",
        )
    difference = _differences(found, true, known)
    sizes = np.abs(difference[known])
    return SurfaceErrors(
        cells=int(known.sum()),
        coverage_percent=float(100 * known.mean()),
        bias_mm=float(np.median(difference[known])),
        noise_mm=_noise(*_scattered(found, known), difference[known][:: _step(known)]),
        within_95_mm=float(np.percentile(sizes, 95)),
        wrong_percent=float(100 * np.mean(sizes > WRONG_MM)),
        stations=tuple(_coverage(s, found, difference) for s in report.items("stations")),
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


def _read_truth(truth: Document) -> RadiusMap:
    """The true map, its azimuths from 0 to 360 and some more on either side, which closes the ring."""
    radius = truth.inside("radius_mm")
    theta, position = radius.array("theta_deg", -1), radius.array("position_m", -1)
    values = radius.array("values", len(position), len(theta))
    if not np.isfinite(values).all() or len(theta) <= 2 * SPARE or len(position) <= SPARE:
        raise radius.error("radius_mm has gaps or hardly any values")
    order = np.argsort(theta % 360)
    theta, values = theta[order] % 360, values[:, order]
    return RadiusMap(
        theta_deg=np.concatenate([theta[-SPARE:] - 360, theta, theta[:SPARE] + 360]),
        position_m=position,
        radius_mm=np.hstack([values[:, -SPARE:], values, values[:, :SPARE]]),
    )


def _differences(found: RadiusMap, true: RadiusMap, known: NDArray[np.bool_]) -> Array:
    """Radius of every cell about the true axis less the true radius there (n, m), NaN where unknown."""
    # a rib is as wide as a few cells of the truth: straight lines between them would cut its crest
    at = RectBivariateSpline(true.position_m, true.theta_deg, true.radius_mm, kx=3, ky=3)
    theta, scaled = _scattered(found, known, step=1)
    radius, position = found.radius_mm[known], np.repeat(found.position_m, known.sum(axis=1))
    powers = np.asarray(np.polynomial.legendre.legvander(scaled, AXIS_ORDER), dtype=np.float64)
    axis = np.zeros((AXIS_ORDER + 1, 2))

    def difference(some: slice) -> tuple[Array, Array]:
        offset = powers[some] @ axis
        x = radius[some] * np.cos(theta[some]) - offset[:, 0]
        z = -radius[some] * np.sin(theta[some]) - offset[:, 1]
        azimuth = np.arctan2(-z, x)
        true_mm = at.ev(position[some], np.degrees(azimuth) % 360)
        return np.asarray(np.hypot(x, z) - true_mm, dtype=np.float64), np.asarray(azimuth, dtype=np.float64)

    if len(np.unique(np.floor(theta % (2 * np.pi) / (np.pi / 4)))) >= LEAST_OCTANTS:
        some = slice(None, None, _step(known))
        for _ in range(AXIS_ROUNDS):
            axis += _eccentricity(*difference(some), powers[some])
    everywhere = np.full(found.radius_mm.shape, np.nan)
    everywhere[known] = difference(slice(None))[0]
    return everywhere


def _eccentricity(difference: Array, azimuth: Array, powers: Array) -> Array:
    """First harmonic of the differences along the cable, as powers of x and z (k, 2).

    The mean is fitted beside it, or a gap in the ring would turn a bias into an eccentricity; what stands
    out is left out, or a few wild cells would pull the axis.
    """
    middle = np.median(difference)
    keep = np.abs(difference - middle) <= 6 * max(_robust_sigma(difference), 1e-12)
    waves = (np.ones_like(azimuth), np.cos(azimuth), -np.sin(azimuth))
    design = np.hstack([wave[:, None] * powers for wave in waves])
    solution, *_ = np.linalg.lstsq(design[keep], difference[keep], rcond=1e-9)
    return np.asarray(solution.reshape(3, -1)[1:].T, dtype=np.float64)


def _coverage(station: Document, found: RadiusMap, difference: Array) -> StationCoverage:
    """The arc in whose bins the middle radius around the station is right."""
    near = np.abs(found.position_m - station.number("position_m")) <= STATION_MM / 2000
    bins = np.floor(found.theta_deg % 360 / BIN_DEG).astype(int)
    values, column = difference[near], np.broadcast_to(bins, (int(near.sum()), len(bins)))
    known = np.isfinite(values)
    # the middle of a bin: a few wild cells do not make a wrong one
    right = [
        abs(float(np.median(values[known & (column == one)]))) <= WRONG_MM
        for one in np.unique(column[known]).tolist()
    ]
    # a coarse map has no cell in some bins: it speaks for as much as its columns are wide
    right_deg = sum(right) * 360.0 / len(np.unique(bins))
    told_deg = station.number_or_nan("coverage_deg")
    return StationCoverage(
        name=station.text("name"),
        told_deg=told_deg,
        right_deg=right_deg,
        overclaimed_deg=max(told_deg - right_deg, 0.0) if np.isfinite(told_deg) else float("nan"),
    )


def _step(known: NDArray[np.bool_]) -> int:
    """Every so many known cells are MOST_CELLS at most."""
    return 1 + int(known.sum()) // MOST_CELLS


def _scattered(places: RadiusMap, known: NDArray[np.bool_], step: int = 0) -> tuple[Array, Array]:
    """Azimuth in radians and position from -1 to 1 over the map of every so many known cells, (k,) each."""
    position, theta = np.meshgrid(places.position_m, np.radians(places.theta_deg), indexing="ij")
    first, last = places.position_m[0], places.position_m[-1]
    scaled = 2 * (position - first) / max(last - first, 1e-12) - 1
    every = slice(None, None, step or _step(known))
    return theta[known][every], scaled[known][every]


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


def _robust_sigma(values: Array) -> float:
    return float(NORMAL_PER_MAD * np.median(np.abs(values - np.median(values))))
