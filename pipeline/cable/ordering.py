"""The order of photographs along the cable, and how far apart they were taken, from the pictures alone.

Takes blocks whose images need not lie in the order of travel (``ordered = false``); gives each image's place
as a share of the travel.  Every two images of a block are compared (:mod:`pipeline.cable.sift_match`); one
adjustment turns the shifts between them into places (:mod:`pipeline.cable.levelling`); the outermost two are
the ends of the travel.  Leaves out which images are used (``frames.py``).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path

import numpy as np

from pipeline.cable.lens import CableScene, LensOptions, solve_lens
from pipeline.cable.levelling import Net, net_places
from pipeline.cable.sift_match import CableView, Marks, SiftOptions, find_marks, find_shift
from pipeline.cable.sources import image_files
from pipeline.cable.survey_records import Block, Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part, silent
from pipeline.core.pictures import read_grey
from pipeline.core.vocabulary import Array, FrameSequence

GROSS_SHARE = 0.04
"""A shift that misses its place by this share of the stand-off contradicts the others."""


@dataclass(frozen=True, kw_only=True)
class OrderOptions:
    """How the order of images is found.

    Attributes:
        sift: marks and their comparison.
        travel_share: the travel that the pictures show may differ from ``cable.travel_m`` by this share.
    """

    sift: SiftOptions = field(default_factory=SiftOptions)
    travel_share: float = field(default=0.2, metadata={"above": 0.0})


def travel_fractions(
    survey: Survey, size_px: Sequence[tuple[int, int]], options: OrderOptions, emit: Emit
) -> tuple[Array | None, ...]:
    """Where along the travel the images of each block were taken.

    Args:
        survey: blocks marked ``ordered = false`` are worked on.
        size_px: (width, height) of each block's images.
        options: see there.
        emit: progress, one event an image.

    Returns:
        Per block, (images,) from 0 to 1 in the order of the names; None where the names give the order.
        Synchronised blocks agree.

    Raises:
        StageError: an image shares no marks with the others; the images fall apart into groups; their way
            contradicts the travel; synchronised blocks contradict each other.
    """
    found = [
        None if block.ordered else _block_fractions(survey, block, size, options, emit)
        for block, size in zip(survey.blocks, size_px, strict=True)
    ]
    if not survey.robot.synchronised:
        return tuple(found)
    known = [fractions for fractions in found if fractions is not None]
    if not known:
        return tuple(found)
    together = np.mean(known, axis=0)
    gross = GROSS_SHARE * survey.robot.standoff_m / survey.cable.travel_m
    for block, fractions in zip(survey.blocks, known, strict=True):
        worst = int(np.argmax(np.abs(fractions - together)))
        if abs(fractions[worst] - together[worst]) > gross:
            raise _error(
                f"image {image_files(block)[worst].name} of {block.name} was taken elsewhere on the way than "
                "the images of that number of the other blocks, but robot.synchronised = true says they are "
                "of one moment",
                "name the images alike in all blocks or set robot.synchronised = false",
            )
    together = (together - together.min()) / np.ptp(together)
    return (together,) * len(found)


def _block_fractions(
    survey: Survey, block: Block, size_px: tuple[int, int], options: OrderOptions, emit: Emit
) -> Array:
    files = image_files(block)
    view = _view(survey, block, files, size_px)
    mask = view.mask(options.sift.limb_deg)
    marks, first, then = [], part(emit, 0.0, 0.5), part(emit, 0.5, 1.0)
    for done, file in enumerate(files):
        first(_event(block, done, len(files)))
        grey = read_grey(file, "frames")
        marks.append(find_marks(grey, view, mask, options.sift))
    net = _net(block, marks, view, options, then)
    places_m = net_places(net, GROSS_SHARE * view.standoff_m, [f.name for f in files], block.name)
    way_m, travel_m = float(np.ptp(places_m)), survey.cable.travel_m
    if abs(way_m / travel_m - 1) > options.travel_share:
        raise _error(
            f"the images of {block.name} show about {way_m:.3g} m of way, but cable.travel_m is {travel_m:g}",
            "give the path between the two outermost images and check standoff_m, focal_px, travel_in_image",
        )
    return np.asarray((places_m - places_m.min()) / way_m)


def _view(survey: Survey, block: Block, files: tuple[Path, ...], size_px: tuple[int, int]) -> CableView:
    """The rough cylinder: nominal, or from the outline in three of the images."""
    lens, standoff_m = block.lens(*size_px), survey.robot.standoff_m
    nominal = survey.cable.diameter_mm
    if nominal is not None:
        radius_m = nominal / 2000
    else:
        frames = FrameSequence(
            block=block.name,
            files=files,
            source_indices=np.arange(len(files)),
            source_count=len(files),
            width_px=size_px[0],
            height_px=size_px[1],
        )
        scene = CableScene(travel_m=survey.cable.travel_m, standoff_m=standoff_m)
        solution = solve_lens(frames, lens, True, block.travel_in_image, LensOptions(), silent, scene=scene)
        radius_m = solution.apparent_radius_m
    if not radius_m > 0:
        raise _error(
            f"the cable's outline was not found in the images of {block.name}",
            "give cable.diameter_mm in survey.toml",
        )
    return CableView(
        lens=lens, travel_in_image=block.travel_in_image, standoff_m=standoff_m, radius_m=radius_m
    )


def _net(block: Block, marks: list[Marks], view: CableView, options: OrderOptions, emit: Emit) -> Net:
    """The shifts between all pairs of images that share enough marks."""
    agree_m = options.sift.agree_share * view.standoff_m
    pairs = list(combinations(range(len(marks)), 2))
    rows = []
    for done, (i, j) in enumerate(pairs):
        if done % 8 == 0:
            emit(_event(block, done, len(pairs)))
        shift = find_shift(marks[i], marks[j], view.standoff_m, options.sift)
        if shift is not None:
            # sway between the two, and the scale of a rough view, outweigh the marks' own noise
            rough_m = np.hypot(agree_m / 4, 0.02 * shift.along_m)
            rows.append((i, j, shift.along_m, np.hypot(rough_m, agree_m / np.sqrt(shift.marks))))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return Net(
        first=table[:, 0].astype(np.int64),
        second=table[:, 1].astype(np.int64),
        along_m=table[:, 2],
        sigma_m=table[:, 3],
    )


def _event(block: Block, done: int, total: int) -> Event:
    return Event(stage="frames", done=done, total=total, block=block.name)


def _error(cause: str, remedy: str) -> StageError:
    return StageError("frames", cause, remedy)
