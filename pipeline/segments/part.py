"""One segment through the stages: like a survey of its own, with its share of the frames.

Up to *joint* it is worked off with its nominal travel taken as exact.  Once the traverse is closed
(:mod:`pipeline.segments.traverse`), :meth:`SegmentChain.place` brings what was adjusted to its true scale,
and the stages after it know true lengths, true places of the stations and what the scale is worth.
"""

from dataclasses import replace

import numpy as np

from pipeline.cable.chain import Chain
from pipeline.cable.crop import CropOptions
from pipeline.cable.joint import RingOrientation
from pipeline.cable.records import CableOptions, SurveyFrames
from pipeline.cable.survey import Survey
from pipeline.core.events import Emit
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.vocabulary import FrameSequence
from pipeline.segments.plan import Segment
from pipeline.segments.scaling import scaled_ring
from pipeline.segments.traverse import Placement


class SegmentChain(Chain):
    """Runs the stages of one segment.

    Args:
        survey: the whole one.
        options, folder, emit: as for any run; the folder is the segment's own.
        segment: which frames.
        frames: of the whole survey, all blocks.
    """

    def __init__(
        self,
        survey: Survey,
        options: CableOptions,
        folder: RunFolder,
        emit: Emit,
        segment: Segment,
        frames: tuple[Product[FrameSequence], ...],
    ) -> None:
        first, last = _ends(survey, segment, frames[0].value)
        cable = replace(survey.cable, travel_m=last - first, stations=())
        super().__init__(replace(survey, cable=cable), options, folder, emit)
        self._segment, self._whole_frames = segment, frames

    _joint_product = "joint_nominal"  # "joint" is the one in true scale, which the segment is opened with

    def _frames(self) -> list[Product[FrameSequence]]:
        mine = SurveyFrames(
            sequences=tuple(_part_of(whole.value, self._segment) for whole in self._whole_frames)
        )
        stamps = [whole.stamp for whole in self._whole_frames]
        kept = self._folder.product("frames", SurveyFrames, lambda: mine, stamps, self._segment)
        root = self._folder.root  # files in a run folder that is moved stay the same
        return [Product.of(sequence, kept.stamp, root=root) for sequence in kept.value.sequences]

    def place(self, whole: Survey, placement: Placement, *, last: bool) -> None:
        """Bring what was adjusted to true scale, and tell the stages to come what lies here.

        Args:
            whole: the survey, with all its stations.
            placement: from the closed traverse.
            last: whether this is the survey's last segment.
        """
        cable = self._survey.cable
        travel_m = placement.scale * cable.travel_m
        stations = tuple(
            replace(s, position_m=s.position_m - placement.start_m)
            for s in whole.cable.stations
            if placement.here(s.position_m, last)
        )
        self._options = replace(self._options, crop=_moved(self._options.crop, -placement.start_m))
        share = placement.scale_sigma / placement.scale
        cable = replace(cable, travel_m=travel_m, travel_sigma_mm=1000 * share * travel_m, stations=stations)
        name = f"{whole.name} · {self._segment.number}"
        self._survey = replace(self._survey, name=name, cable=cable)
        nominal: Product[RingOrientation] = self.made["joint"][0]
        scale = placement.scale
        self.made["joint"] = [
            self._folder.product(
                "joint", RingOrientation, lambda: scaled_ring(nominal.value, scale), nominal, scale
            )
        ]


def _ends(survey: Survey, segment: Segment, frames: FrameSequence) -> tuple[float, float]:
    """Nominal places of the segment's outermost frames."""
    y_m = frames.places_m(survey.cable.travel_m)
    return float(y_m[segment.first]), float(y_m[segment.last])


def _moved(crop: CropOptions, by_m: float) -> CropOptions:
    """The same stretch, which is stated in places of the whole cable, in the segment's own."""
    from_m, to_m = (None if end_m is None else end_m + by_m for end_m in (crop.from_m, crop.to_m))
    return replace(crop, from_m=from_m, to_m=to_m)


def _part_of(whole: FrameSequence, segment: Segment) -> FrameSequence:
    """The segment's frames, with the share of its travel at which each was nominally taken."""
    places = whole.places_m(1.0)[segment.frames]
    return replace(
        whole,
        files=whole.files[segment.frames],
        source_indices=whole.source_indices[segment.frames],
        fractions=np.asarray((places - places[0]) / (places[-1] - places[0])),
    )
