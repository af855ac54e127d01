"""What the report tells of the relief: the features, and the map of heights they were found in."""

from dataclasses import dataclass

from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class ReliefFeature:
    """Something that stands proud of the sheath or is dented.

    Attributes:
        kind: ``"bulge"``, ``"dent"`` or ``"ridge"``.
        height_mm, sigma_mm: over the base, of a dent below it, and the standard deviation; positive.
        position_m, azimuth_deg: its middle; of a ridge, the point of its crest at the middle of the travel.
        length_mm: along the cable.
        width_mm: around it; of a ridge, across the ridge.
        pitch_m: of a ridge, positive where the azimuth grows along the cable; else NaN.
    """

    kind: str
    height_mm: float
    sigma_mm: float
    position_m: float
    azimuth_deg: float
    length_mm: float
    width_mm: float
    pitch_m: float = float("nan")


@dataclass(frozen=True, kw_only=True)
class ReliefSummary:
    """The relief of the whole cable.

    Attributes:
        features: what stands out, ridges first, then the highest.
        height_mm: (n, m) heights over the base; rows along the cable, columns around; NaN where not measured.
        theta_range_deg: azimuth at the left and at the right edge of the map.
        y_range_m: position along the cable at the first and at the last edge.
        level_mm: what stands out exceeds this.
    """

    features: tuple[ReliefFeature, ...]
    height_mm: Array
    theta_range_deg: tuple[float, float]
    y_range_m: tuple[float, float]
    level_mm: float

    def __post_init__(self) -> None:
        if self.height_mm.ndim != 2:
            raise ValueError(f"ReliefSummary.height_mm has shape {self.height_mm.shape}, wanted (None, None)")
