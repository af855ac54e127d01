"""What an evaluation tells: errors against truth, frozen records with the unit in each name.

Differences are always result minus truth; rms is the root mean square.
"""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class StationError:
    """One station, as a column of the paper's Table 2.

    Attributes:
        name, position_m: the station.
        model_mm, truth_mm, difference_mm: diameters and their difference.
        relative_percent: size of the difference in percent of the truth.
        sigma_mm: standard deviation that the run claims, NaN where it claims none.
        z: size of the difference in sigmas, NaN without sigma.
    """

    name: str
    position_m: float
    model_mm: float
    truth_mm: float
    difference_mm: float
    relative_percent: float
    sigma_mm: float
    z: float


@dataclass(frozen=True, kw_only=True)
class DiameterErrors:
    """All stations.

    Attributes:
        stations: one each, in the order of the truth.
        mean_absolute_mm: MAE of Table 2.
        largest_mm: largest size of a difference.
    """

    stations: tuple[StationError, ...]
    mean_absolute_mm: float
    largest_mm: float


@dataclass(frozen=True, kw_only=True)
class CameraErrors:
    """Exterior orientation of one block, or of all of them together ("all").

    Attributes:
        block: its name.
        frames: number of frames compared.
        radial_mm, around_mm, along_mm: rms of the projection centres' errors away from the axis, around it,
            and along it.
        position_mm: rms of their length.
        attitude_deg: rms of the angle between the attitudes.
    """

    block: str
    frames: int
    radial_mm: float
    around_mm: float
    along_mm: float
    position_mm: float
    attitude_deg: float


@dataclass(frozen=True, kw_only=True)
class CameraComparison:
    """All cameras, as they stand in the cable frame and after the best rigid fit to truth.

    Attributes:
        as_they_stand, fitted: one entry a block, then "all".
        fit_rotation_deg, fit_translation_mm: size of the motion that the fit applied.
    """

    as_they_stand: tuple[CameraErrors, ...]
    fitted: tuple[CameraErrors, ...]
    fit_rotation_deg: float
    fit_translation_mm: float


@dataclass(frozen=True, kw_only=True)
class LensErrors:
    """Interior orientation of one block.

    Attributes:
        block: its name.
        focal_percent: error of the focal length in percent of the truth.
        lambda_error: error of lambda, in the unit of radius that the truth uses.
        displacement_px: largest distance over the image between a pixel undistorted with the lens of the run
            and with the true one; infinite where the run's lens folds.
    """

    block: str
    focal_percent: float
    lambda_error: float
    displacement_px: float


@dataclass(frozen=True, kw_only=True)
class SurfaceErrors:
    """The map of radii against the true one.

    Attributes:
        cells: number of cells with a radius.
        coverage_percent: those of all cells whose place the truth covers.
        bias_mm: median difference.
        noise_mm: robust standard deviation after mean and low orders are taken out: what is left is noise of
            the dense step and texture, not position of the strips.
        within_95_mm: 95 percent of the differences are smaller than this.
        bow_mm: largest distance of the measured axis from a straight line, NaN where the ring is not closed.
    """

    cells: int
    coverage_percent: float
    bias_mm: float
    noise_mm: float
    within_95_mm: float
    bow_mm: float


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """A run against its truth; parts that the truth does not know are None.

    Attributes:
        name: of the survey.
        diameters: at the stations.
        cameras, lenses, surface: the other parts.
        straightness_mm_per_m: of the axis, as the run reports it; the true axis is straight.
    """

    name: str
    diameters: DiameterErrors
    cameras: CameraComparison | None
    lenses: tuple[LensErrors, ...] | None
    surface: SurfaceErrors | None
    straightness_mm_per_m: float
