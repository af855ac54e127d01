"""Operators of the POS: import a file with a look at its names, show paths, write the constructed one."""

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from pipeline.core.errors import StageError

from ..gather import gather_blocks, survey_path
from ..results import collections
from ..results.paths import pos_of, remove_path, show_path, with_rows
from ..results.view import frame
from ..wording import framed
from .base import Operator

_UNDOABLE = {"REGISTER", "UNDO"}


class _BlockOperator(Operator):
    """One that needs a shown block; not registered itself."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown."""
        if context.scene.cabletwin.survey.block() is None:
            cls.poll_message_set("The survey has no blocks")
            return False
        return True


class CABLETWIN_OT_pos_import(_BlockOperator, ImportHelper):
    """Take the shown block's POS from a file."""

    bl_idname = "cabletwin.pos_import"
    bl_label = "Import POS"
    bl_description = "Read the chosen block's exterior orientation from a CSV file, and see which names match"
    bl_options = _UNDOABLE

    filename_ext = ".csv"
    filter_glob: bpy.props.StringProperty(default="*.csv;*.txt", options={"HIDDEN"})

    def work(self, context: bpy.types.Context) -> None:
        """Look at the file; only one that can be read becomes the block's."""
        scene = context.scene
        block = scene.cabletwin.survey.block()
        problem = look_at(scene, block.name, bpy.path.abspath(self.filepath))
        block.pos, block.pos_from = bpy.path.abspath(self.filepath), "CSV"
        if problem:
            remove_path(scene, block.name)  # that of another POS
            self.report({"WARNING"}, problem)
        else:
            show_path(scene, block.name)


class CABLETWIN_OT_pos_check(_BlockOperator):
    """Look at the shown block's POS file again."""

    bl_idname = "cabletwin.pos_check"
    bl_label = "Check Again"
    bl_description = "Look again which rows of the file match the frames"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Look at the file."""
        scene = context.scene
        block = scene.cabletwin.survey.block()
        if not block.pos:
            raise StageError("pos", f"{block.name} has no POS file", "import one")
        problem = look_at(scene, block.name, bpy.path.abspath(block.pos))
        if problem:
            self.report({"WARNING"}, problem)


class CABLETWIN_OT_pos_show(_BlockOperator):
    """Draw the paths of all cameras."""

    bl_idname = "cabletwin.pos_show"
    bl_label = "Show Camera Paths"
    bl_description = "Draw where the cameras are taken to have been, constructed or measured"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Draw each; a block whose POS cannot be had does not stand in the way of the others."""
        scene = context.scene
        refused: list[StageError] = []
        for block in scene.cabletwin.survey.blocks:
            try:
                show_path(scene, block.name)
            except StageError as error:
                refused.append(error)
        if len(refused) == len(scene.cabletwin.survey.blocks):
            raise refused[0]
        context.view_layer.update()  # a new curve's box is wrong until then
        frame(context, scene, collections.SETUP, collections.PATHS)
        if refused:
            self.report({"WARNING"}, framed(str(refused[0])))


class CABLETWIN_OT_pos_write(_BlockOperator, ExportHelper):
    """Write the shown block's constructed POS to a file."""

    bl_idname = "cabletwin.pos_write"
    bl_label = "Write POS"
    bl_description = (
        "Write the constructed exterior orientation of every frame as CSV, to be edited and imported"
    )
    bl_options = {"REGISTER"}

    filename_ext = ".csv"
    filter_glob: bpy.props.StringProperty(default="*.csv", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Propose a name beside the survey."""
        survey = context.scene.cabletwin.survey
        folder = survey_path(survey).parent if survey.filepath else Path()
        self.filepath = str(folder / f"{survey.block().name}_pos.csv")
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: bpy.types.Context) -> None:
        """Construct and write."""
        write_constructed(
            context.scene, context.scene.cabletwin.survey.block().name, Path(bpy.path.abspath(self.filepath))
        )


def look_at(scene: bpy.types.Scene, name: str, filepath: str) -> str:
    """Match a POS file with the frames of a block, for the panel.

    Returns:
        What the reconstruction would refuse it for, or "".

    Raises:
        StageError: the file cannot be read, or the block's source has no frames.
    """
    from dataclasses import replace

    from pipeline.cable.frames import every_frame
    from pipeline.cable.pos_file import match_pos

    survey = gather_blocks(scene, name, constructed=True)
    frames = every_frame(survey.blocks[0])
    match = match_pos(Path(filepath), frames)
    problem = ""
    try:
        measured = replace(survey.blocks[0], pos=Path(filepath))
        pos_of(replace(survey, blocks=(measured,)), with_rows(frames, match))
    except StageError as error:
        problem = framed(str(error))
    scene.cabletwin.pos.take(name, filepath, match, problem)
    return problem


def write_constructed(scene: bpy.types.Scene, name: str, path: Path) -> None:
    """Write a block's POS as it is constructed from the travel, whatever file it has.

    Raises:
        StageError: it cannot be constructed, or the place not be written.
    """
    from pipeline.cable.frames import every_frame
    from pipeline.cable.pos_file import write_pos

    survey = gather_blocks(scene, name, constructed=True)
    frames = every_frame(survey.blocks[0])
    write_pos(path, survey.blocks[0], frames, pos_of(survey, frames))


classes = (CABLETWIN_OT_pos_import, CABLETWIN_OT_pos_check, CABLETWIN_OT_pos_show, CABLETWIN_OT_pos_write)
