"""What the evaluation of a steel run tells: errors against truth, frozen, with the unit in each name.

Differences are result minus truth; rms is the root mean square; a figure that is not known is NaN.
"""

from dataclasses import dataclass

Triple = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class SigmaCheck:
    """Whether the claimed standard deviations are true.

    Attributes:
        count: values compared.
        within_percent: part of the errors that are at most two sigma.
        over_rms: root mean square of the sigmas over that of the errors: 1 is right, below it too sure.
    """

    count: int
    within_percent: float
    over_rms: float


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
class StationErrors:
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
    rms_mm: float
    largest_mm: float
    rms_arcsec: float
    fitted_rms_mm: float
    chained_rms_mm: float
    icp_rms_mm: float
    chained_fitted_rms_mm: float
    icp_fitted_rms_mm: float
    fit_rotation_arcsec: float
    fit_translation_mm: float
    sigma: SigmaCheck


@dataclass(frozen=True, kw_only=True)
class TargetErrors:
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
    rms_mm: float
    largest_mm: float
    sigma: SigmaCheck


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


@dataclass(frozen=True, kw_only=True)
class NodeError:
    """One true node that was found.

    Attributes:
        name, found: as built and as the run calls it.
        true_mm, found_mm: amount of the eccentricity.
        error_mm: length of the difference of the two vectors.
        amount_error_mm: difference of the amounts.
        sigma_mm: claimed.
        significant, eccentric: what the run says, what is true.
        ball_mm: distance of the ball's centre from its true place.
    """

    name: str
    found: str
    true_mm: float
    found_mm: float
    error_mm: float
    amount_error_mm: float
    sigma_mm: float
    significant: bool
    eccentric: bool
    ball_mm: float


@dataclass(frozen=True, kw_only=True)
class NodeErrors:
    """All nodes.

    Attributes:
        entries: those found and judged.
        true: nodes that there are.
        eccentric: of them truly eccentric and judged.
        false: reported eccentric without being so; false_percent of those judged that are not.
        missed: truly eccentric, judged, and not reported.
        rms_mm, largest_mm: vector error of the truly eccentric.
        amount_rms_mm, amount_largest_mm: error of the amount of the truly eccentric.
        ball_rms_mm: of the balls' centres.
        sigma: of the amounts of the truly eccentric.
    """

    entries: tuple[NodeError, ...]
    true: int
    eccentric: int
    false: int
    false_percent: float
    missed: int
    rms_mm: float
    largest_mm: float
    amount_rms_mm: float
    amount_largest_mm: float
    ball_rms_mm: float
    sigma: SigmaCheck


@dataclass(frozen=True, kw_only=True)
class ColumnError:
    """One column.

    Attributes:
        name: of the column.
        true_mm, found_mm, deviation_error_mm: its deviation.
        north_error_mm, east_error_mm: of both components.
        direction_error_deg: angle between found and true direction.
        sigma_mm: claimed, of the deviation.
        over, truly_over: verdicts.
    """

    name: str
    true_mm: float
    found_mm: float
    deviation_error_mm: float
    north_error_mm: float
    east_error_mm: float
    direction_error_deg: float
    sigma_mm: float
    over: bool
    truly_over: bool


@dataclass(frozen=True, kw_only=True)
class ColumnErrors:
    """All columns.

    Attributes:
        entries: those found.
        missing: names of true columns that the run does not judge.
        rms_mm, largest_mm: error of the deviation.
        component_rms_mm, component_largest_mm: error of north and east.
        right, wrong: verdicts.
        over, truly_over: columns flagged, and to be flagged.
        sigma: over both components.
    """

    entries: tuple[ColumnError, ...]
    missing: tuple[str, ...]
    rms_mm: float
    largest_mm: float
    component_rms_mm: float
    component_largest_mm: float
    right: int
    wrong: int
    over: int
    truly_over: int
    sigma: SigmaCheck


@dataclass(frozen=True, kw_only=True)
class DeflectionErrors:
    """Deflection of the balls below the plane of the supports, which the truth is put to as well.

    Attributes:
        nodes: compared.
        rms_mm, largest_mm: of the differences.
        found_mm, true_mm: largest deflection.
        verdict_right: whether the run's verdict on the limit is the truth's.
        sigma: over the nodes that are no supports.
    """

    nodes: int
    rms_mm: float
    largest_mm: float
    found_mm: float
    true_mm: float
    verdict_right: bool
    sigma: SigmaCheck


@dataclass(frozen=True, kw_only=True)
class MemberErrors:
    """Fitted members of one kind.

    Attributes:
        true, found: how many there are, and how many of them were found.
        doubled: further finds of one that was found already.
        false: finds where none is.
        place_rms_mm: of the axis, or the centre.
        radius_rms_mm, radius_bias_mm: of the radius.
    """

    true: int
    found: int
    doubled: int
    false: int
    place_rms_mm: float
    radius_rms_mm: float
    radius_bias_mm: float


@dataclass(frozen=True, kw_only=True)
class FusionErrors:
    """Photos fused with the scans.

    Attributes:
        photos, true_photos: cameras compared, cameras that there are.
        scale_percent: how much too large the photo model is in the site frame.
        rms_mm, largest_mm: of the cameras' places; fitted_rms_mm after the best rigid fit.
        median_mm: of the distances from cloud to cloud, as the run tells them.
    """

    photos: int
    true_photos: int
    scale_percent: float
    rms_mm: float
    largest_mm: float
    fitted_rms_mm: float
    median_mm: float


@dataclass(frozen=True, kw_only=True)
class SteelEvaluation:
    """Everything; None where the run did not judge it."""

    name: str
    stations: StationErrors
    targets: TargetErrors
    gross: GrossVerdict
    nodes: NodeErrors | None
    columns: ColumnErrors | None
    deflection: DeflectionErrors | None
    rods: MemberErrors | None
    balls: MemberErrors | None
    fusion: FusionErrors | None
