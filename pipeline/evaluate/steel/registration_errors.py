"""Errors of a registration against the truth: stations, targets, gross errors; signs as in compared.py."""

from dataclasses import dataclass

from pipeline.evaluate.steel.compared import Compared

Triple = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class StationError:
    """One station.

    Attributes:
        name, ring: the station, set-ups away from the base.
        offset_mm: of its position, site frame.
        distance_mm: length of that.
        attitude_arcsec: angle between found and true attitude.
        sigma_xyz_mm: claimed.
        fitted_mm: distance after the best rigid fit of all stations and targets.
        chained_mm, icp_mm: distance of the position that chaining and ICP give.
        chained_fitted_mm, icp_fitted_mm: the same after the best rigid fit of that way's stations.
    """

    name: str
    ring: int
    offset_mm: Triple
    distance_mm: float
    attitude_arcsec: float
    sigma_xyz_mm: Triple
    fitted_mm: float
    chained_mm: float
    icp_mm: float
    chained_fitted_mm: float
    icp_fitted_mm: float


@dataclass(frozen=True, kw_only=True)
class StationErrors(Compared):
    """All stations; the rms figures leave out a base that defines the frame.

    Attributes:
        entries: one each.
        rms_mm, largest_mm, rms_arcsec: as they stand.
        fitted_rms_mm: after the best rigid fit: without what the base's own attitude is off by, which turns
            the whole site and so grows with the distance from the base.
        chained_rms_mm, icp_rms_mm: the other ways, as they stand.
        chained_fitted_rms_mm, icp_fitted_rms_mm: each after its own best fit.
        fit_rotation_arcsec, fit_translation_mm: of the best fit.
        sigma: over the coordinates.
    """

    entries: tuple[StationError, ...]
    rms_arcsec: float
    fitted_rms_mm: float
    chained_rms_mm: float
    icp_rms_mm: float
    chained_fitted_rms_mm: float
    icp_fitted_rms_mm: float
    fit_rotation_arcsec: float
    fit_translation_mm: float


@dataclass(frozen=True, kw_only=True)
class TargetErrors(Compared):
    """Targets.

    Attributes:
        true, matched: how many there are, and how many of them were found.
        false: found where none is.
        rms_mm, largest_mm: distance from the truth of those matched.
        sigma: found sigma against the error of a coordinate.
    """

    true: int
    matched: int
    false: int


@dataclass(frozen=True, kw_only=True)
class GrossVerdict:
    """Gross errors by what they are ("moved T15", "misnamed S03 T07").

    Attributes:
        named: truly there and named.
        missed: truly there and not named.
        false: named and not there.
    """

    named: tuple[str, ...]
    missed: tuple[str, ...]
    false: tuple[str, ...]
