"""A long survey segment by segment: all adjusted, the traverse closed, all finished, then the whole.

Takes the survey with its frames; gives the report on the whole cable.  Every segment is a run folder of its
own under ``RUN/segments`` that can be opened like any other; what is kept between them is small, so memory
is what one segment needs.  A segment in which nothing can be found is told and left out: its neighbours are
laid beside the gap by the nominal travel.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from pipeline.cable.joint import RingOrientation
from pipeline.cable.joint_path import RingPath
from pipeline.cable.records import CableOptions
from pipeline.cable.ring import Ring
from pipeline.cable.run import STAGES
from pipeline.cable.survey import Survey
from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.memory import peak_memory_mb
from pipeline.core.rotations import vector_from_rotation
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.vocabulary import Array, FrameSequence
from pipeline.report.labels import Language
from pipeline.report.segment_records import SegmentSummary
from pipeline.report.types import ReportData, TruthStation
from pipeline.report.written import write_files, write_run
from pipeline.segments.part import SegmentChain
from pipeline.segments.plan import SEGMENTS, Segment
from pipeline.segments.told import Told, told
from pipeline.segments.traverse import Placement, close_traverse, unseen_path
from pipeline.segments.whole import whole_report
from pipeline.segments.whole_ring import Place, join_rings

ADJUSTED = STAGES[: STAGES.index("joint") + 1]
SURVEY_WIDE = ("run", "survey", "frames", "pos", "report")
"""What is wrong there is wrong for all segments."""


@dataclass(frozen=True, kw_only=True)
class _Adjusted:
    """What is kept of an adjusted segment: its path, and the attitudes of its cameras (b, frames, 3, 3)."""

    path: RingPath
    rotations: Array


class SegmentedRun:
    """A survey that is worked off in segments.

    Args:
        survey, options: of the whole.
        frames: of the whole, all blocks.
        segments: at least two.
        folder: of the whole run.
        folder_of: makes the run folder of a segment, from its path and that of the whole.
        emit: progress; may raise Cancelled.
    """

    def __init__(
        self,
        survey: Survey,
        options: CableOptions,
        frames: tuple[Product[FrameSequence], ...],
        segments: tuple[Segment, ...],
        folder: RunFolder,
        folder_of: Callable[[Path, Path], RunFolder],
        emit: Emit,
    ) -> None:
        self._survey, self._options, self._emit = survey, options, emit
        self._frames, self._segments, self._folder = frames, segments, folder
        self._folders = [folder_of(folder.path / SEGMENTS / s.name, folder.path) for s in segments]
        self._lost: dict[int, StageError] = {}

    def write(self, truth: tuple[TruthStation, ...], language: Language, last: str) -> ReportData | None:
        """Work off all segments and write the whole.

        Args:
            truth: true diameters, where they are known.
            language: that the pages open in.
            last: stop after this stage; "report" is the whole.

        Returns:
            What the report tells, or None where ``last`` comes before the end.

        Raises:
            StageError: bad input, or nothing can be found in any segment.
        """
        stages = ADJUSTED[: ADJUSTED.index(last) + 1] if last in ADJUSTED else ADJUSTED
        adjusted = [self._adjusted(s, stages) for s in self._segments]
        if last in ADJUSTED[:-1]:
            return None
        placements, rolls = self._placed(adjusted)
        if last == "joint":
            return None
        parts = [
            None if s.number in self._lost else self._finished(s, p, truth, language, last)
            for s, p in zip(self._segments, placements, strict=True)
        ]
        if last != "report":
            return None
        if len(self._lost) == len(self._segments):
            raise next(iter(self._lost.values()))
        return self._whole(parts, placements, rolls, truth, language)

    def _chain(self, segment: Segment) -> SegmentChain:
        def emit(event: Event) -> None:
            self._emit(replace(event, segment=segment.number, segments=len(self._segments)))

        folder = self._folders[segment.number - 1]
        return SegmentChain(self._survey, self._options, folder, emit, segment, self._frames)

    def _adjusted(self, segment: Segment, stages: tuple[str, ...]) -> _Adjusted | None:
        """A segment through the stages up to *joint*; None where it does not get there."""
        chain = self._chain(segment)
        try:
            for name in stages:
                chain.run(name, None)
        except StageError as error:
            if error.stage in SURVEY_WIDE:
                raise
            self._lost[segment.number] = error
            return None
        if "joint" not in chain.made:
            return None
        ring: RingOrientation = chain.made["joint"][0].value
        if ring.path is None:
            raise ValueError("an adjusted ring has a path")
        return _Adjusted(path=ring.path, rotations=np.stack([b.poses.rotations for b in ring.blocks]))

    def _placed(self, adjusted: list[_Adjusted | None]) -> tuple[tuple[Placement, ...], list[float]]:
        cable, frames = self._survey.cable, self._frames[0].value
        nominal_m = frames.places_m(cable.travel_m)
        sizes = [a.path.size_m for a in adjusted if a is not None] or [self._survey.robot.standoff_m]
        paths = tuple(
            unseen_path(nominal_m[s.frames], float(np.mean(sizes))) if a is None else a.path
            for s, a in zip(self._segments, adjusted, strict=True)
        )
        placements = close_traverse(
            self._segments,
            paths,
            cable.travel_m,
            cable.travel_sigma_mm / 1000,
            self._options.segments.traverse,
        )
        rolls = [0.0]
        for (one, other), (a, b) in zip(pairwise(self._segments), pairwise(adjusted), strict=True):
            rolls.append(rolls[-1] - (_turned(one, other, a, b) if a and b else 0.0))
        return placements, rolls

    def _finished(
        self,
        segment: Segment,
        placement: Placement,
        truth: tuple[TruthStation, ...],
        language: Language,
        last: str,
    ) -> Told | None:
        """A segment from its place to its report; None where it does not get there."""
        chain, at_end = self._chain(segment), segment is self._segments[-1]
        try:
            for name in ADJUSTED:
                chain.run(name, None)
            chain.place(self._survey, placement, last=at_end)
            for name in STAGES[len(ADJUSTED) : None if last == "report" else STAGES.index(last) + 1]:
                chain.run(name, None)
        except StageError as error:
            if error.stage in SURVEY_WIDE:
                raise
            self._lost[segment.number] = error
            return None
        if last != "report":
            return None
        mine = tuple(t for t in truth if placement.here(t.position_m, at_end))
        local = tuple(replace(t, position_m=t.position_m - placement.start_m) for t in mine)

        def write() -> Told:
            return told(
                write_run(chain.result(), chain.folder, local, language, chain.emit), placement, last=at_end
            )

        stamps = [p for made in chain.made.values() for p in made]
        return chain.folder.product("report", Told, write, *stamps, local, language, placement).value

    def _whole(
        self,
        parts: list[Told | None],
        placements: tuple[Placement, ...],
        rolls: list[float],
        truth: tuple[TruthStation, ...],
        language: Language,
    ) -> ReportData:
        began = time.monotonic()
        self._emit(Event(stage="report", done=0, total=1))
        there = [n for n, part in enumerate(parts) if part is not None]
        places = [self._place(n, placements, rolls, set(there)) for n in there]
        files = (self._folders[n].path / "products" / "all-ring.npz" for n in there)
        rings = (store.load(Ring, file, self._folder.path) for file in files)
        ring = join_rings(rings, places, self._survey.cable.travel_m)
        data = whole_report(
            self._survey,
            tuple(part for part in parts if part is not None),
            tuple(self._summary(n, placements[n], rolls[n]) for n in there),
            ring,
            len(self._frames[0].value),
            truth,
            self._seconds(),
            peak_memory_mb(),
        )
        gaps = tuple(
            _gap(self._segments[n - 1], placements[n - 1], self._lost[n]) for n in sorted(self._lost)
        )
        data = replace(data, warnings=gaps + data.warnings)
        return write_files(data, ring, self._folder.path, language, self._emit, began)

    def _place(self, n: int, placements: tuple[Placement, ...], rolls: list[float], there: set[int]) -> Place:
        """Where a segment's surface goes; it fades into the neighbours that are there."""
        fades = [self._shared_m(a, a + 1, placements) if {a, a + 1} <= there else None for a in (n - 1, n)]
        return Place(start_m=placements[n].start_m, roll=rolls[n], fade_in_m=fades[0], fade_out_m=fades[1])

    def _shared_m(self, a: int, b: int, placements: tuple[Placement, ...]) -> tuple[float, float]:
        """The inner half of the range that two neighbours share: near its end a segment sees less."""
        middle = placements[b].from_m
        one, other = self._segments[a], self._segments[b]
        step_m = self._survey.cable.travel_m / max(len(self._frames[0].value) - 1, 1)
        quarter_m = (one.last - other.first) * step_m / 4
        return middle - quarter_m, middle + quarter_m

    def _summary(self, n: int, placement: Placement, roll: float) -> SegmentSummary:
        segment = self._segments[n]
        y_m = self._frames[0].value.places_m(self._survey.cable.travel_m)
        return SegmentSummary(
            name=segment.name,
            from_m=placement.from_m,
            to_m=placement.to_m,
            start_m=placement.start_m,
            length_m=placement.scale * float(y_m[segment.last] - y_m[segment.first]),
            frames=segment.last - segment.first + 1,
            scale=placement.scale,
            scale_sigma=placement.scale_sigma,
            roll_deg=float(np.rad2deg(roll)),
            link_ppm=placement.link_ppm,
        )

    def _seconds(self) -> dict[str, float]:
        """Time of every stage, all segments together."""
        seconds = dict(self._folder.stage_seconds())
        for folder in self._folders:
            for stage, value in folder.stage_seconds().items():
                name = "joint" if stage == "joint_nominal" else stage
                seconds[name] = round(seconds.get(name, 0.0) + value, 3)
        return seconds


def _turned(one: Segment, other: Segment, a: _Adjusted, b: _Adjusted) -> float:
    """Azimuth in the other's frame less that in the one's, radians: from the cameras both have."""
    shared = np.arange(other.first, one.last + 1)
    first = a.rotations[:, shared - one.first]
    second = b.rotations[:, shared - other.first]
    return float(vector_from_rotation(np.swapaxes(second, -1, -2) @ first)[..., 1].mean())


def _gap(segment: Segment, placement: Placement, error: StageError) -> str:
    where = f"{placement.from_m:.2f} to {placement.to_m:.2f} m"
    return f"Segment {segment.name}, {where}, is missing: {error.cause}."
