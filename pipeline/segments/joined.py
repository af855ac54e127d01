"""The finished segments as one product: surface, page and files of the whole cable.

Takes each :class:`FinishedSegment`; writes into the run folder.  The segments' surfaces are read one after
the other; what they tell is small.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pipeline.cable.ring import Ring
from pipeline.cable.survey import Survey
from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.memory import peak_memory_mb
from pipeline.core.runfolder import RunFolder
from pipeline.core.vocabulary import Array, FrameSequence
from pipeline.report.labels import Language
from pipeline.report.segment_records import SegmentSummary
from pipeline.report.types import ReportData, TruthStation
from pipeline.report.written import write_files
from pipeline.segments.bends import AxisPart, whole_axis
from pipeline.segments.plan import Segment
from pipeline.segments.straightened import straightened
from pipeline.segments.told import Told
from pipeline.segments.traverse import AdjustedSegment, Placement
from pipeline.segments.whole import whole_report
from pipeline.segments.whole_ring import Place, join_rings

LEAST_PLACES = 3
"""Of a segment's axis, for it to be told."""
UNKNOWN = np.full(2, np.nan), float("nan")
"""Bend to a next segment that is not there."""


@dataclass(frozen=True, kw_only=True)
class FinishedSegment:
    """One segment at its end.

    Attributes:
        segment, placement: which, and where it lies.
        adjusted: its cameras; None where nothing could be found in it.
        folder: its run folder.
        told: what it tells; None where nothing could be found in it, and then
        lost: why.
    """

    segment: Segment
    adjusted: AdjustedSegment | None
    placement: Placement
    folder: RunFolder
    told: Told | None
    lost: StageError | None


def write_whole(
    survey: Survey,
    frames: FrameSequence,
    segments: tuple[FinishedSegment, ...],
    folder: RunFolder,
    truth: tuple[TruthStation, ...],
    language: Language,
    emit: Emit,
) -> ReportData:
    """Join the segments, and write everything a person opens of the whole.

    Args:
        survey: the whole one.
        frames: of its first block.
        segments: all of them, in order; at least one with something to tell.
        folder: of the whole run.
        truth: true diameters, where they are known.
        language: that the page opens in.
        emit: progress; may raise Cancelled.

    Raises:
        StageError: the folder cannot be written.
    """
    began = time.monotonic()
    there = [s for s in segments if s.told is not None]
    nominal_m = frames.places_m(survey.cable.travel_m)
    rings = _rings(there, part(emit, 0.0, 0.5))
    ring = join_rings(rings, _places(segments, nominal_m), survey.cable.travel_m)
    chains = unbroken(segments)
    axes = tuple(whole_axis([_axis_part(s) for s in c], to_the_end=c[-1] is segments[-1]) for c in chains)
    bends = {
        one.segment.number: (lean, sigma)
        for chain, axis in zip(chains, axes, strict=True)
        for one, lean, sigma in zip(chain, axis.bend_mm_per_m, axis.bend_sigma_mm_per_m, strict=False)
    }
    data = whole_report(
        survey,
        tuple(s.told for s in there if s.told is not None),
        tuple(_summary(s, nominal_m, bends.get(s.segment.number, UNKNOWN)) for s in there),
        axes,
        ring,
        len(frames),
        truth,
        _seconds(folder, segments),
        peak_memory_mb(),
    )
    data = replace(data, warnings=_gaps(segments) + data.warnings)
    return write_files(data, ring, folder.path, language, part(emit, 0.5, 1.0), began)


def _rings(segments: list[FinishedSegment], emit: Emit) -> Iterator[Ring]:
    """The segments' surfaces about their axes, read when they are asked for."""
    for number, one in enumerate(segments):
        emit(Event(stage="report", done=number, total=len(segments)))
        ring = store.load(Ring, one.folder.path / "products" / "all-ring.npz", one.folder.root)
        axis = one.told.axis if one.told is not None else None
        yield (
            ring
            if axis is None
            else straightened(ring, axis.position_m - one.placement.start_m, axis.centre_mm)
        )


def unbroken(segments: tuple[FinishedSegment, ...]) -> list[list[FinishedSegment]]:
    """Chains of neighbours that tell of their axes: a segment that does not breaks the chain."""
    chains: list[list[FinishedSegment]] = [[]]
    for one in segments:
        if _tells(one, last=one is segments[-1]):
            chains[-1].append(one)
        elif chains[-1]:
            chains.append([])
    return [chain for chain in chains if chain]


def _tells(one: FinishedSegment, *, last: bool) -> bool:
    """Whether enough of its axis lies between its hand-overs."""
    if one.told is None:
        return False
    return sum(one.placement.here(y, last) for y in one.told.axis.position_m) >= LEAST_PLACES


def _axis_part(of: FinishedSegment) -> AxisPart:
    if of.told is None or of.adjusted is None:
        raise ValueError("a segment that tells of its axis was adjusted")
    return AxisPart(
        segment=of.segment,
        adjusted=of.adjusted,
        placement=of.placement,
        rotation=of.told.rotation,
        y_m=of.told.axis.position_m,
        centre_mm=of.told.axis.centre_mm,
    )


def _places(segments: tuple[FinishedSegment, ...], nominal_m: np.ndarray) -> list[Place]:
    """Where the surfaces go; each fades into the neighbours that are there."""
    places = []
    for before, here, behind in zip((None, *segments), segments, (*segments[1:], None), strict=False):
        if here.told is not None:
            places.append(
                Place(
                    start_m=here.placement.start_m,
                    roll=here.placement.roll,
                    fade_in_m=_fade(before, here, nominal_m),
                    fade_out_m=_fade(here, behind, nominal_m),
                )
            )
    return places


def _fade(
    one: FinishedSegment | None, other: FinishedSegment | None, nominal_m: np.ndarray
) -> tuple[float, float] | None:
    """The inner half of the range that two neighbours share: near its end a segment sees less."""
    if one is None or other is None or one.told is None or other.told is None:
        return None
    quarter_m = float(nominal_m[one.segment.last] - nominal_m[other.segment.first]) / 4
    return one.placement.to_m - quarter_m, one.placement.to_m + quarter_m


def _summary(of: FinishedSegment, nominal_m: np.ndarray, bend: tuple[Array, float]) -> SegmentSummary:
    segment, placement = of.segment, of.placement
    return SegmentSummary(
        name=segment.name,
        from_m=placement.from_m,
        to_m=placement.to_m,
        start_m=placement.start_m,
        length_m=placement.scale * float(nominal_m[segment.last] - nominal_m[segment.first]),
        frames=segment.last - segment.first + 1,
        scale=placement.scale,
        scale_sigma=placement.scale_sigma,
        roll_deg=float(np.rad2deg(placement.roll)),
        link_ppm=placement.link_ppm,
        bend_mm_per_m=(float(bend[0][0]), float(bend[0][1])),
        bend_sigma_mm_per_m=float(bend[1]),
    )


def _seconds(whole: RunFolder, segments: tuple[FinishedSegment, ...]) -> dict[str, float]:
    """Time of every stage, all segments together."""
    seconds = {stage: value for stage, value in whole.stage_seconds().items() if stage == "frames"}
    for one in segments:
        for stage, value in one.folder.stage_seconds().items():
            name = "joint" if stage == "joint_nominal" else stage
            seconds[name] = round(seconds.get(name, 0.0) + value, 3)
    return seconds


def _gaps(segments: tuple[FinishedSegment, ...]) -> tuple[str, ...]:
    """A sentence for each segment in which nothing was found."""
    return tuple(
        f"Segment {s.segment.name}, {s.placement.from_m:.2f} to {s.placement.to_m:.2f} m, is missing: "
        f"{s.lost.cause}."
        for s in segments
        if s.lost is not None
    )
