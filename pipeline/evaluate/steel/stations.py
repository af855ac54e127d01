"""Stations of a run against the true ones, by name: position, attitude, the other ways, sigma."""

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.figures import (
    ARCSEC_PER_RADIAN,
    most,
    places_of,
    rigid_fit,
    rms,
    rotation_angle,
    sigma_check,
    triple,
)
from pipeline.evaluate.steel.registration_errors import StationError, StationErrors
from pipeline.evaluate.steel.targets import matched_places

LEAST_FIT = 3
"""Fewer places hold no turn."""


def compare_stations(report: Document, truth: Document) -> StationErrors:
    """Compare every station of the run.

    Raises:
        StageError: the truth does not know a station.
    """
    true = {row.text("name"): row for row in truth.items("stations")}
    rows = list(report.items("stations"))
    for row in rows:
        if row.text("name") not in true:
            raise report.error(f"station {row.text('name')} is not in {truth.file}")
    places = places_of(rows, "position_m")
    wanted = np.array([true[row.text("name")].array("translation", 3) for row in rows])
    found_targets, true_targets = matched_places(report, truth)
    moving, fixed = np.concatenate([places, found_targets]), np.concatenate([wanted, true_targets])
    turn, shift = rigid_fit(moving, fixed)
    fitted = places @ turn.T + shift
    names = [row.text("name") for row in rows]
    chained, icp = (_other_way(report, names, wanted, way) for way in ("chained", "icp"))
    entries = tuple(
        StationError(
            name=row.text("name"),
            ring=int(row.number_or_nan("ring")) if "ring" in row else 0,
            offset_mm=triple(1000 * (places[n] - wanted[n])),
            distance_mm=1000 * float(np.linalg.norm(places[n] - wanted[n])),
            attitude_arcsec=ARCSEC_PER_RADIAN
            * rotation_angle(true[row.text("name")].array("rotation", 3, 3).T @ row.array("rotation", 3, 3)),
            sigma_xyz_mm=triple(row.array("sigma_xyz_mm", 3)),
            fitted_mm=1000 * float(np.linalg.norm(fitted[n] - wanted[n])),
            chained_mm=chained[0][n],
            icp_mm=icp[0][n],
            chained_fitted_mm=chained[1][n],
            icp_fitted_mm=icp[1][n],
        )
        for n, row in enumerate(rows)
    )
    return _summed(entries, turn, shift)


def _other_way(
    report: Document, names: list[str], wanted: Array, way: str
) -> tuple[list[float], list[float]]:
    """Distances from the truth, mm, of another way's positions: as they stand, and after its best fit."""
    places = np.full_like(wanted, np.nan)
    for row in report.items("comparison") if "comparison" in report else ():
        if way in row and "position_m" in row.inside(way) and row.text("station") in names:
            places[names.index(row.text("station"))] = row.inside(way).array("position_m", 3)
    fitted, known = places.copy(), np.isfinite(places).all(axis=1)
    if known.sum() >= LEAST_FIT:
        turn, shift = rigid_fit(places[known], wanted[known])
        fitted = places @ turn.T + shift
    return _off(places, wanted), _off(fitted, wanted)


def _off(places: Array, wanted: Array) -> list[float]:
    found: list[float] = (1000 * np.linalg.norm(places - wanted, axis=1)).tolist()
    return found


def _summed(entries: tuple[StationError, ...], turn: Array, shift: Array) -> StationErrors:
    """Figures over all stations that are not held."""
    free = [row for row in entries if any(sigma > 0 for sigma in row.sigma_xyz_mm)] or list(entries)
    return StationErrors(
        entries=entries,
        rms_mm=rms(row.distance_mm for row in free),
        largest_mm=most(row.distance_mm for row in free),
        rms_arcsec=rms(row.attitude_arcsec for row in free),
        fitted_rms_mm=rms(row.fitted_mm for row in entries),
        chained_rms_mm=rms(row.chained_mm for row in free),
        icp_rms_mm=rms(row.icp_mm for row in free),
        chained_fitted_rms_mm=rms(row.chained_fitted_mm for row in entries),
        icp_fitted_rms_mm=rms(row.icp_fitted_mm for row in entries),
        fit_rotation_arcsec=ARCSEC_PER_RADIAN * rotation_angle(turn),
        fit_translation_mm=1000 * float(np.linalg.norm(shift)),
        sigma=sigma_check(
            (value for row in entries for value in row.offset_mm),
            (value for row in entries for value in row.sigma_xyz_mm),
        ),
    )
