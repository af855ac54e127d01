"""A block's lens as the stage *lens* settles it: options, what it must know of the scene, and the result."""

from dataclasses import dataclass, field
from enum import StrEnum

from pipeline.cable.plumb_records import PlumbLineFit, PlumbLineOptions
from pipeline.cable.silhouette import SilhouetteOptions
from pipeline.core.vocabulary import Lens


class LensMethod(StrEnum):
    """Where a lens came from."""

    GIVEN = "given"
    PLUMB_LINES = "plumb lines"
    CHESSBOARD = "chessboard"
    NONE = "none"


@dataclass(frozen=True, kw_only=True)
class LensOptions:
    """How lambda is come by.

    Attributes:
        correct: false holds lambda at 0: the deliberately uncorrected run of the paper's figures 5 and 6.
        most_frames: edges are looked for in at most this many frames, evenly chosen.
        need_outline: both edges of the cable must be in the picture; false allows cameras so close that the
            cable fills it (then lambda must be given).
        missing_share: so large a share of the frames may lack an outline when lambda is estimated.
        silhouette: how edges are found.
        plumb_lines: what is taken for granted of the cable's shape.
    """

    correct: bool = True
    most_frames: int = field(default=48, metadata={"minimum": 2})
    need_outline: bool = True
    missing_share: float = field(default=0.2, metadata={"minimum": 0.0, "maximum": 1.0})
    silhouette: SilhouetteOptions = field(default_factory=SilhouetteOptions)
    plumb_lines: PlumbLineOptions = field(default_factory=PlumbLineOptions)


@dataclass(frozen=True, kw_only=True)
class CableScene:
    """What the survey says of the block's view, roughly.

    Attributes:
        travel_m: way of the robot between the source's first and last frame.
        standoff_m: projection centre to cable axis.
        diameter_m: nominal diameter where known; only chooses between several long edges in the picture.
    """

    travel_m: float
    standoff_m: float
    diameter_m: float | None = None


@dataclass(frozen=True, kw_only=True)
class LensSolution:
    """The lens to work with.

    Attributes:
        lens: with lambda and its sigma; the focal length stays as stated.
        method: where lambda came from.
        apparent_radius_m: radius of the cable by its outline and the stand-off; NaN where none was seen.
        plumb_lines: diagnostics, where lambda was estimated.
    """

    lens: Lens
    method: LensMethod
    apparent_radius_m: float
    plumb_lines: PlumbLineFit | None = None
