"""What a person should look at although the run goes on: sentences for the log and the report.

Takes what a stage was given or has made; gives sentences, none where all is as it should be.  Leaves out what
cannot be worked with, which is refused (:class:`~pipeline.core.errors.StageError`).
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.cable.adjust import Orientation
from pipeline.cable.sources import image_files, is_video
from pipeline.cable.survey_records import Block

RIG_FACTOR, RIG_PX = 1.5, 0.05
"""Blocks that belong together miss by the same together as alone (1.05 times at most on the benchmark's
surveys); where two angles are swapped or a clock is not shared, by 5 to 13 times."""
REGULAR_SHARE = 0.5
"""Numbers that go up by the same step at least so often count pictures; others may be times or anything."""

_NUMBERED = re.compile(r"(.*?)(\d+)(\D*)")


@dataclass(frozen=True)
class _Gap:
    """Two pictures of a block between which numbers are missing."""

    block: str
    before: str
    behind: str


def numbering_cautions(blocks: Sequence[Block]) -> tuple[str, ...]:
    """Say where pictures that are taken to lie at even steps skip numbers."""
    found = [
        gap for b in blocks if b.ordered and not is_video(b) if (gap := _first_gap(b.name, image_files(b)))
    ]
    if not found:
        return ()
    names, first = ", ".join(gap.block for gap in found), found[0]
    return (
        f"The pictures of {names} skip numbers (in {first.block}, {first.behind} comes next after "
        f"{first.before}), but are taken to lie at even steps of the travel: bring the missing pictures, or "
        "set ordered = false in every such block, so that their places are found from the pictures.",
    )


def _first_gap(block: str, files: Sequence[Path]) -> _Gap | None:
    parts = [_NUMBERED.fullmatch(file.stem) for file in files]
    if len({(p[1], p[3]) for p in parts if p}) != 1 or None in parts:
        return None
    steps = np.diff([int(p[2]) for p in parts if p])
    if not len(steps) or np.mean(steps == steps.min()) < REGULAR_SHARE:
        return None
    wide = np.flatnonzero(steps > steps.min())
    return _Gap(block, files[wide[0]].name, files[wide[0] + 1].name) if len(wide) else None


def rig_cautions(alone: Sequence[Orientation], together: Sequence[Orientation]) -> tuple[str, ...]:
    """Say so where the cameras, each good alone, contradict each other as one rig.

    Args:
        alone: the blocks as they were adjusted each for itself.
        together: the same blocks, adjusted as one rig.
    """
    before, behind = (np.array([o.reprojection_px for o in blocks]) for blocks in (alone, together))
    if (behind <= RIG_FACTOR * before + RIG_PX).all():
        return ()
    worst = int(np.argmax(behind / (RIG_FACTOR * before + RIG_PX)))
    return (
        "The cameras do not fit together as one rig: adjusted together, marks miss their places by up to "
        f"{behind[worst]:.2f} px, each block alone by {before[worst]:.2f} px; likely angle_deg of two blocks "
        "are swapped, or the cameras share no clock: correct angle_deg, or set robot.synchronised = false.",
    )
