"""Where a long survey is cut: runs of frames that neighbours share a few of.

Takes the number of frames; gives the segments.  Leaves out everything else.
"""

from dataclasses import dataclass, field
from math import ceil

SEGMENTS = "segments"
"""Folder of the segments in a run folder."""


@dataclass(frozen=True, kw_only=True)
class TraverseOptions:
    """What neighbouring segments may differ by beyond the errors of their adjustments, parts per million.

    Attributes:
        ring_ppm: the size of the ring of cameras (temperature: 12 ppm a degree for steel).
        link_ppm: the robot's way over the frames that two segments share.
    """

    ring_ppm: float = field(default=50.0, metadata={"above": 0.0})
    link_ppm: float = field(default=30.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class SegmentOptions:
    """How a long survey is worked off.

    Attributes:
        frames: a survey of more frames a block is cut into segments of at most so many, so that memory stays
            what one segment needs; 0: never cut.  Less than three times ``shared`` is taken for that.
        shared: frames that two neighbours have in common: they tie the segments' places and scales.
        traverse: how the segments are tied to each other.
    """

    frames: int = field(default=60, metadata={"minimum": 0})
    shared: int = field(default=12, metadata={"minimum": 4})
    traverse: TraverseOptions = field(default_factory=TraverseOptions)


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A run of frames, worked off like a survey of its own.

    Attributes:
        number: from 1.
        first, last: its outermost frames, numbers among the frames worked on.
    """

    number: int
    first: int
    last: int

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.number:03d}"

    @property
    def frames(self) -> slice:
        """Its frames."""
        return slice(self.first, self.last + 1)


def cut(count: int, options: SegmentOptions) -> tuple[Segment, ...]:
    """Cut so many frames into segments of about the same length; a single one where they are few.

    Two neighbours share at least ``options.shared`` frames, and no frame belongs to three segments.
    """
    if not options.frames or count <= options.frames:
        return (Segment(number=1, first=0, last=count - 1),)
    longest = max(options.frames, 3 * options.shared + 1)
    parts = ceil((count - options.shared) / (longest - options.shared))
    firsts = [round(n * (count - options.shared) / parts) for n in range(parts)]
    lasts = [*(first + options.shared - 1 for first in firsts[1:]), count - 1]
    return tuple(
        Segment(number=n, first=a, last=b) for n, (a, b) in enumerate(zip(firsts, lasts, strict=True), 1)
    )
