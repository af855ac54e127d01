"""A block's lambda from its own video, before anything is run: what the lens stage would find.

Takes the survey and the block's name; gives the :class:`~pipeline.cable.lens.LensSolution`.  Only that
block's source is looked at, so its frames are the sharpest of its own; a run of cameras on one clock takes
frames that are sharp in all of them.  Keeps nothing: the frames lie in a temporary folder meanwhile.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

from pipeline.cable.frames import FrameOptions, extract_frames
from pipeline.cable.lens import CableScene, LensOptions, LensSolution, solve_lens
from pipeline.cable.survey import Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, silent


def estimate_lens(
    survey: Survey,
    name: str,
    frame_options: FrameOptions,
    lens_options: LensOptions,
    emit: Emit = silent,
) -> LensSolution:
    """Estimate lambda of one block from the edges of the cable, whatever the survey says of it.

    Args:
        survey: gives the block's view of the cable.
        name: of the block.
        frame_options, lens_options: as for a run.
        emit: progress, the stages *frames* and *lens*.

    Raises:
        StageError: no such block; its source is unreadable or shows no cable.
    """
    block = next((b for b in survey.blocks if b.name == name), None)
    if block is None:
        known = ", ".join(b.name for b in survey.blocks)
        raise StageError("lens", f"the survey has no block {name}", f"name one of {known}")
    block = replace(block, lens_spec=replace(block.lens_spec, division_lambda=None))
    cable, robot = survey.cable, survey.robot
    nominal = None if cable.diameter_mm is None else cable.diameter_mm / 1000
    with tempfile.TemporaryDirectory(prefix="cabletwin-lens-") as folder:
        (frames,) = extract_frames(replace(survey, blocks=(block,)), frame_options, Path(folder), emit)
        return solve_lens(
            frames,
            block.lens(frames.width_px, frames.height_px),
            False,
            block.travel_in_image,
            replace(lens_options, correct=True),
            emit,
            scene=CableScene(travel_m=cable.travel_m, standoff_m=robot.standoff_m, diameter_m=nominal),
        )


def solution_lines(found: LensSolution) -> str:
    """What to write under ``[block.lens]`` of survey.toml."""
    lens, fit = found.lens, found.plumb_lines
    lines = [
        "[block.lens]",
        f"focal_px = {lens.focal_px:g}  # as stated",
        f"division_lambda = {lens.division_lambda:.6g}",
        f"lambda_sigma = {lens.lambda_sigma:.2g}",
        f'lambda_radius = "{lens.lambda_radius}"',
    ]
    if fit is not None:
        lines.append(f"# {fit.line_count} edges, {fit.noise_px:.2f} px noise")
    return "\n".join(lines)
