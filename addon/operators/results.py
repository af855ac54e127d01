"""Operators of the results: bring a run folder into the scene; look through a frame's camera."""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError
from pipeline.opened import whole_of

from ..pieces import Pieces, at_once
from ..preferences import preferences
from ..properties.job import SHOWING
from ..results.collections import BLOCKS, MOSAIC, SPARSE
from ..results.show import show_run
from ..results.steel_run import is_steel
from ..results.view import clear_startup, frame, show_pictures
from ..segments import chosen, number_of, segments_of
from .base import FolderChoice, Operator
from .running import run_folder


class RunOpener(Operator):
    """An operator that brings in a run, which must not mix with another one; not registered itself."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Not while a job's results come in."""
        job = context.window_manager.cabletwin_job
        if job.running and job.stage == SHOWING:
            cls.poll_message_set("A job is running")
            return False
        return True


class CABLETWIN_OT_results_open(RunOpener):
    """Show what a run folder holds, finished or half finished."""

    bl_idname = "cabletwin.results_open"
    bl_label = "Open Results"
    bl_description = "Show what the run folder holds, finished or half finished"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> None:
        """Read and show."""
        scene = context.scene
        at_once(present_run(context, scene, run_folder(scene.cabletwin.run)))


class CABLETWIN_OT_results_choose(FolderChoice, RunOpener):
    """Choose a run folder and show it."""

    bl_idname = "cabletwin.results_choose"
    bl_label = "Open Run Folder"
    bl_description = "Choose a run folder and show what it holds"
    bl_options = {"REGISTER", "UNDO"}

    def show(self, context: bpy.types.Context, folder: Path) -> None:
        """The scene remembers the folder where that went well."""
        run, whole = context.scene.cabletwin.run, whole_of(folder)
        run.segment = number_of(folder) or run.segment
        at_once(present_run(context, context.scene, whole))
        run.folder = str(whole)


def present_run(context: bpy.types.Context, scene: bpy.types.Scene, folder: Path) -> Pieces[None]:
    """Show a run folder in a scene, and look at it; of a long survey the segment that the panel asks for.

    Raises:
        StageError: there is nothing to show.
    """
    if is_steel(folder):
        raise StageError(
            "run", f"{folder} is the run of a steel structure", "open it in the panel Steel structure"
        )
    shown = chosen(folder, scene.cabletwin.run.segment)
    yield from show_run(scene, shown, preferences(context).cloud_points)
    scene.cabletwin.results.segments = len(segments_of(folder))
    scene.cabletwin.run.segment = max(number_of(shown), 1)
    clear_startup(scene)
    show_pictures(context, scene)
    frame(context, scene, MOSAIC, BLOCKS, SPARSE)


classes = (CABLETWIN_OT_results_open, CABLETWIN_OT_results_choose)
