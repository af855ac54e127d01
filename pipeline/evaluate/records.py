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
        base_model_mm, base_truth_mm, base_difference_mm, base_sigma_mm: the same for the bare sheath, without
            ribs, bulges and dents; NaN where run or truth does not tell it.
    """

    name: str
    position_m: float
    model_mm: float
    truth_mm: float
    difference_mm: float
    relative_percent: float
    sigma_mm: float
    z: float
    base_model_mm: float
    base_truth_mm: float
    base_difference_mm: float
    base_sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class DiameterErrors:
    """All stations.

    Attributes:
        stations: one each, in the order of the truth.
        mean_absolute_mm: MAE of Table 2.
        largest_mm: largest size of a difference.
        base_mean_absolute_mm: MAE of the bare sheath's diameters, NaN where they are not known at every
            station.
    """

    stations: tuple[StationError, ...]
    mean_absolute_mm: float
    largest_mm: float
    base_mean_absolute_mm: float


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
class StationCoverage:
    """What the run says to have seen at a station, and what of it is right.

    Attributes:
        name: of the station.
        told_deg: arc that the run calls covered, NaN where it does not say.
        right_deg: arc where the map of radii is there and right.
        overclaimed_deg: how much more is told than is right, 0 where nothing is.
    """

    name: str
    told_deg: float
    right_deg: float
    overclaimed_deg: float


@dataclass(frozen=True, kw_only=True)
class SurfaceErrors:
    """The map of radii against the true one, both about the true axis.

    Attributes:
        cells: number of cells with a radius.
        coverage_percent: those of all cells whose place the truth covers.
        bias_mm: median difference.
        noise_mm: robust standard deviation after mean and low orders are taken out: what is left is noise of
            the dense step and texture, not position of the strips.
        within_95_mm: 95 percent of the differences are smaller than this.
        wrong_percent: share of the cells with a radius that are off by more than half a millimetre.
        stations: coverage told and right at every station.
    """

    cells: int
    coverage_percent: float
    bias_mm: float
    noise_mm: float
    within_95_mm: float
    wrong_percent: float
    stations: tuple[StationCoverage, ...]


@dataclass(frozen=True, kw_only=True)
class AxisErrors:
    """The axis, where run and truth both know it.

    Attributes:
        places: number of places compared.
        length_m: from the first to the last of them.
        bow_mm, true_bow_mm: largest distance of the run's and of the true axis from its chord, the line
            through its two ends.
        bow_difference_mm: the one less the other.
        rms_mm, largest_mm: distance between the two axes, each less its own best straight line.
    """

    places: int
    length_m: float
    bow_mm: float
    true_bow_mm: float
    bow_difference_mm: float
    rms_mm: float
    largest_mm: float


@dataclass(frozen=True, kw_only=True)
class ReliefError:
    """One true bulge, dent or rib, and what the run says of it; NaN where it was missed.

    Attributes:
        kind: "bulge", "dent" or "ridge".
        position_m, azimuth_deg: true place; of a rib that was found, the point of its crest that the run
            names.
        truth_mm, found_mm, difference_mm: size of the height, and found less true.
        sigma_mm: standard deviation that the run claims, NaN where it claims none.
        away_mm: distance between the two on the surface, for a rib across it.
    """

    kind: str
    position_m: float
    azimuth_deg: float
    truth_mm: float
    found_mm: float
    difference_mm: float
    sigma_mm: float
    away_mm: float


@dataclass(frozen=True, kw_only=True)
class ReliefErrors:
    """All of them.

    Attributes:
        entries: one for each that is truly there.
        ridges_true, ridges_found: number of ribs, and of those the run tells.
        missed: true ones that the run does not tell.
        false: what the run tells and is not there.
        largest_mm: largest size of a height's difference, NaN where nothing was found that is there.
    """

    entries: tuple[ReliefError, ...]
    ridges_true: int
    ridges_found: int
    missed: int
    false: int
    largest_mm: float


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """A run against its truth; parts that the truth or the run does not know are None.

    Attributes:
        name: of the survey.
        diameters: at the stations.
        cameras, lenses, surface, axis, relief: the other parts.
        straightness_mm_per_m: of the axis, as the run reports it.
    """

    name: str
    diameters: DiameterErrors
    cameras: CameraComparison | None
    lenses: tuple[LensErrors, ...] | None
    surface: SurfaceErrors | None
    axis: AxisErrors | None
    relief: ReliefErrors | None
    straightness_mm_per_m: float
