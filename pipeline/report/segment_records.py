"""What the report tells of the segments that a long survey was worked off in."""

from dataclasses import dataclass
from math import nan


@dataclass(frozen=True, kw_only=True)
class SegmentSummary:
    """One segment of a long survey.

    Attributes:
        name: of its folder under ``segments``.
        from_m, to_m: the part of the cable that the report tells from it.
        start_m: place of its own frame's origin; its own report counts from there.
        length_m: of its travel, frames shared with neighbours included.
        frames: a block.
        scale, scale_sigma: of its lengths against the nominal travel, and its standard deviation.
        roll_deg: by how much the robot was turned about the cable against the first segment.
        link_ppm: how far the frames shared with the next segment want another scale; NaN for the last.
        bend_mm_per_m: by how much the next segment's axis leans out of this one's, towards x and z of the
            whole cable; NaN where no next one is known.
        bend_sigma_mm_per_m: standard deviation of either.
    """

    name: str
    from_m: float
    to_m: float
    start_m: float
    length_m: float
    frames: int
    scale: float
    scale_sigma: float
    roll_deg: float
    link_ppm: float
    bend_mm_per_m: tuple[float, float] = (nan, nan)
    bend_sigma_mm_per_m: float = nan
