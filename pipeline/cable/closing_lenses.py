"""Shared marks of blocks whose lenses are not known: found once for the lenses' sake, and again through them.

Takes the blocks as they were adjusted alone, where a wrong lens leaves each out of shape; gives their shared
marks.  Unrolled through a focal length that is 5 % off, pictures are stretched the more the closer to the
limb, each block's towards its own: matched marks are off by the same at every seam, which the closed ring
pays for with the focal lengths, and marks that agree on no common shift are lost.
"""

from dataclasses import replace

from pipeline.cable.closing import ClosingBlock, ClosingOptions, SharedMarks, find_shared_marks
from pipeline.cable.joint import JointBlock, JointOptions, orient_ring
from pipeline.cable.pos import RobotPriors
from pipeline.core.events import Emit, part
from pipeline.core.vocabulary import Lens


def close_ring(
    blocks: tuple[ClosingBlock, ...],
    alone: tuple[JointBlock, ...],
    robot: RobotPriors,
    options: ClosingOptions,
    joint: JointOptions,
    emit: Emit,
) -> SharedMarks:
    """Find the marks that blocks share, through lenses that the ring has told where nobody else did.

    Args:
        blocks: adjusted alone, with their frames.
        alone: the same, as the joint adjustment takes them.
        robot: priors.
        options, joint: how marks are found, how the ring is adjusted.
        emit: progress.
    """
    if all(lens_known(block.orientation.lens) for block in blocks):
        return find_shared_marks(blocks, options, emit)
    marks = find_shared_marks(blocks, options, part(emit, 0.0, 0.45))
    adjusting = part(emit, 0.45, 0.55)
    oriented = orient_ring(
        alone, marks, robot, joint, lambda event: adjusting(replace(event, stage="closing"))
    )
    again = tuple(replace(b, orientation=o) for b, o in zip(blocks, oriented, strict=True))
    return find_shared_marks(again, options, part(emit, 0.55, 1.0))


def lens_known(lens: Lens) -> bool:
    """Whether nothing of the lens is left to find."""
    return lens.focal_sigma_px == 0 and lens.lambda_sigma == 0
