"""The POS of a block in the viewport: the path of its camera, with the camera's axes at the frames."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.options import build
from pipeline.core.vocabulary import Array, FrameSequence, Poses, PosPriors

from ..gather import gather_blocks
from . import collections

if TYPE_CHECKING:
    from pipeline.cable.pos_file import PosMatch
    from pipeline.cable.survey import Survey

MOST_AXES = 200
"""No more cameras than this get axes; the path passes through all."""

AXIS_SHARE = 0.05
"""Length of a drawn axis, by the stand-off."""

COLOURS = {
    "TRAVEL": (0.25, 0.55, 0.9, 1.0),
    "CSV": (0.95, 0.6, 0.1, 1.0),
    "x": (0.9, 0.15, 0.2, 1.0),
    "y": (0.4, 0.75, 0.1, 1.0),
    "z": (0.15, 0.4, 0.9, 1.0),
}


def show_path(scene: bpy.types.Scene, name: str) -> None:
    """Draw the path of one block's camera, in place of the one that is there.

    Raises:
        StageError: the block's POS cannot be constructed or read.
    """
    survey = gather_blocks(scene, name)
    poses, origin = pos_of(survey).poses, "CSV" if survey.blocks[0].pos else "TRAVEL"
    remove_path(scene, name)
    target = collections.collection(scene, collections.PATHS)
    made = bpy.data.objects.new(f"{name} path", _curve(poses, origin, AXIS_SHARE * survey.robot.standoff_m))
    made["cabletwin_block"], made["cabletwin_pos"] = name, origin
    made.hide_select = True
    target.objects.link(made)


def remove_path(scene: bpy.types.Scene, name: str) -> None:
    """Take a block's path away, where there is one."""
    target = collections.existing(scene, collections.PATHS)
    for old in [i for i in target.objects if i.get("cabletwin_block") == name] if target else ():
        collections.remove(old)


def pos_of(survey: "Survey", frames: FrameSequence | None = None) -> PosPriors:
    """The POS of a survey's only block as the pipeline takes it, of all frames that it can be told of.

    Args:
        survey: of one block.
        frames: that are asked for; without, all of the video, or all that have a row.

    Raises:
        StageError: what the pipeline would refuse.
    """
    from pipeline.cable.frames import every_frame
    from pipeline.cable.pos import PosOptions, pos_of_block
    from pipeline.cable.pos_file import match_pos

    (block,) = survey.blocks
    if frames is None:
        frames = every_frame(block)
        if block.pos is not None:
            frames = with_rows(frames, match_pos(block.pos, frames))
    if block.pos is None and not block.ordered:
        raise StageError(
            "pos",
            f"the places of {block.name} are found from its pictures, for they are not in order",
            "run the reconstruction",
        )
    options = build(PosOptions, survey.stage_options("pos"), key="options.pos")
    return pos_of_block(survey, block, frames, options)


def with_rows(frames: FrameSequence, match: "PosMatch") -> FrameSequence:
    """The frames that a POS file has a row for, of all frames of a source.

    Raises:
        StageError: there is none.
    """
    kept = sorted({number for number in match.frames if number >= 0})
    if not kept:
        raise StageError(
            "pos",
            f"no row of the POS file names a frame of {frames.block}",
            f"name the image file or a frame from 0 to {frames.source_count - 1}",
        )
    files: tuple[Path, ...] = tuple(frames.files[number] for number in kept)
    return replace(frames, files=files, source_indices=np.array(kept))


def _curve(poses: Poses, origin: str, axis_m: float) -> bpy.types.Curve:
    """The path, and a line along each axis of the camera: x right, y down, z forward."""
    data = bpy.data.curves.new("Camera path", "CURVE")
    data.dimensions = "3D"
    data.bevel_depth, data.bevel_resolution = axis_m / 16, 1
    for key in (origin, "x", "y", "z"):
        data.materials.append(_material(key))
    centres = poses.centres
    _line(data, centres, 0)
    shown = np.unique(np.linspace(0, len(centres) - 1, min(len(centres), MOST_AXES)).round().astype(int))
    for k in shown:
        for number, axis in enumerate(poses.rotations[k]):
            _line(data, np.stack([centres[k], centres[k] + axis_m * axis]), number + 1)
    return data


def _line(data: bpy.types.Curve, points: Array, material: int) -> None:
    spline = data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.points.foreach_set(
        "co", np.column_stack([points, np.ones(len(points))]).astype(np.float32).ravel()
    )
    spline.material_index = material


def _material(key: str) -> bpy.types.Material:
    name = f"CableTwin path {key}"
    found = bpy.data.materials.get(name)
    if found is None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = COLOURS[key]
    return found
