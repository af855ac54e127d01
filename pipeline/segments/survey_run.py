"""A long survey segment by segment: all adjusted, the traverse closed, all finished, then the whole.

Takes the survey with its frames; gives the report on the whole cable.  Every segment is a run folder of its
own under ``RUN/segments`` that can be opened like any other; what is kept between them is small, so memory
is what one segment needs.  A segment in which nothing can be found is told and left out: its neighbours are
laid beside the gap by the nominal travel.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.cable.chain import Chain
from pipeline.cable.joint import RingOrientation
from pipeline.cable.records import CableOptions
from pipeline.cable.run import STAGES
from pipeline.cable.survey import Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Event
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.vocabulary import FrameSequence
from pipeline.report.labels import Language
from pipeline.report.types import ReportData, TruthStation
from pipeline.report.written import write_run
from pipeline.segments.joined import FinishedSegment, write_whole
from pipeline.segments.part import SegmentChain
from pipeline.segments.plan import SEGMENTS, Segment
from pipeline.segments.told import Told, told
from pipeline.segments.traverse import AdjustedSegment, Placement, close_traverse, unseen_segment
from pipeline.set_aside import drop_set_aside

ADJUSTED = STAGES[: STAGES.index("joint") + 1]
SURVEY_WIDE = ("run", "survey", "frames", "pos", "report")
"""What is wrong there is wrong for all segments."""


class SegmentedRun:
    """A survey that is worked off in segments.

    Args:
        survey, options: of the whole.
        whole: its chain, with the frames made; its progress may raise Cancelled.
        segments: at least two.
        folder_of: makes the run folder of a segment, from its path and that of the whole.
    """

    def __init__(
        self,
        survey: Survey,
        options: CableOptions,
        whole: Chain,
        segments: tuple[Segment, ...],
        folder_of: Callable[[Path, Path], RunFolder],
    ) -> None:
        self._survey, self._options, self._emit = survey, options, whole.emit
        self._frames: tuple[Product[FrameSequence], ...] = tuple(whole.made["frames"])
        self._segments, self._folder = segments, whole.folder
        folder = whole.folder
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
        if last == "joint":
            return None
        placements = self._placed(adjusted)
        finished = tuple(
            self._finished(segment, known, placement, truth, language, last)
            for segment, known, placement in zip(self._segments, adjusted, placements, strict=True)
        )
        if last != "report":
            return None
        if len(self._lost) == len(self._segments):
            raise next(iter(self._lost.values()))
        return write_whole(
            self._survey, self._frames[0].value, finished, self._folder, truth, language, self._emit
        )

    def _chain(self, segment: Segment) -> SegmentChain:
        def emit(event: Event) -> None:
            self._emit(replace(event, segment=segment.number, segments=len(self._segments)))

        folder = self._folders[segment.number - 1]
        return SegmentChain(self._survey, self._options, folder, emit, segment, self._frames)

    def _adjusted(self, segment: Segment, stages: tuple[str, ...]) -> AdjustedSegment | None:
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
        return AdjustedSegment(path=ring.path, rotations=np.stack([b.poses.rotations for b in ring.blocks]))

    def _placed(self, adjusted: list[AdjustedSegment | None]) -> tuple[Placement, ...]:
        cable = self._survey.cable
        nominal_m = self._frames[0].value.places_m(cable.travel_m)
        sizes = [a.path.size_m for a in adjusted if a is not None] or [self._survey.robot.standoff_m]
        stood_in = tuple(
            unseen_segment(nominal_m[s.frames], float(np.mean(sizes))) if a is None else a
            for s, a in zip(self._segments, adjusted, strict=True)
        )
        sigma_m, known = cable.travel_sigma_mm / 1000, self._options.segments.traverse
        return close_traverse(self._segments, stood_in, cable.travel_m, sigma_m, known)

    def _finished(
        self,
        segment: Segment,
        adjusted: AdjustedSegment | None,
        placement: Placement,
        truth: tuple[TruthStation, ...],
        language: Language,
        last: str,
    ) -> FinishedSegment:
        """A segment from its place to its report, or to where nothing was found."""
        found = None
        if segment.number not in self._lost:
            try:
                found = self._told(segment, placement, truth, language, last)
            except StageError as error:
                if error.stage in SURVEY_WIDE:
                    raise
                self._lost[segment.number] = error
        return FinishedSegment(
            segment=segment,
            adjusted=adjusted,
            placement=placement,
            folder=self._folders[segment.number - 1],
            told=found,
            lost=self._lost.get(segment.number),
        )

    def _told(
        self,
        segment: Segment,
        placement: Placement,
        truth: tuple[TruthStation, ...],
        language: Language,
        last: str,
    ) -> Told | None:
        chain, at_end = self._chain(segment), segment is self._segments[-1]
        for name in ADJUSTED:
            chain.run(name, None)
        chain.place(self._survey, placement, last=at_end)
        for name in STAGES[len(ADJUSTED) : None if last == "report" else STAGES.index(last) + 1]:
            chain.run(name, None)
        if last != "report":
            return None
        here = tuple(
            replace(t, position_m=t.position_m - placement.start_m)
            for t in truth
            if placement.here(t.position_m, at_end)
        )

        def write() -> Told:
            data = write_run(chain.result(), chain.folder, here, language, chain.emit)
            # joined as one rig, the blocks stay where the adjustment has them: the mosaic's frame is its own
            return told(data, chain.made["ring"][0].value.alignment.rotation, placement, last=at_end)

        stamps = [product for made in chain.made.values() for product in made]
        found = chain.folder.product("report", Told, write, *stamps, here, language, placement).value
        if not (chain.folder.path / "report.json").exists():
            write()  # its files were set aside when a stage was made again by itself, to the same end
        drop_set_aside(chain.folder.path)
        return found
