"""What the evaluation of a steel run tells: errors against truth, frozen, with the unit in each name.

Differences are result minus truth; rms is the root mean square; a figure that is not known is NaN.
"""

from dataclasses import dataclass

from pipeline.evaluate.steel.registration_errors import GrossVerdict, StationErrors, TargetErrors
from pipeline.evaluate.steel.structure_errors import ColumnErrors, DeflectionErrors, MemberErrors, NodeErrors


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
