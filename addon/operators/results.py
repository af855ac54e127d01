"""Operators of the results: bring a run folder into the scene; look through a frame's camera."""

from pathlib import Path

import bpy

from ..preferences import preferences
from ..results.show import show_run
from .base import Operator
from .reconstruct import run_folder


class CABLETWIN_OT_results_open(Operator):
    """Show what a run folder holds, finished or half finished."""

    bl_idname = "cabletwin.results_open"
    bl_label = "Open Results"
    bl_description = "Show what the run folder holds, finished or half finished"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> None:
        """Read and show."""
        scene = context.scene
        show_run(scene, run_folder(scene.cabletwin.run), preferences(context).cloud_points)


class CABLETWIN_OT_results_choose(Operator):
    """Choose a run folder and show it."""

    bl_idname = "cabletwin.results_choose"
    bl_label = "Open Run Folder"
    bl_description = "Choose a run folder and show what it holds"
    bl_options = {"REGISTER", "UNDO"}

    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: bpy.types.Context) -> None:
        """Read and show; the scene remembers the folder where that went well."""
        folder = Path(bpy.path.abspath(self.directory))
        show_run(context.scene, folder, preferences(context).cloud_points)
        context.scene.cabletwin.run.folder = str(folder)


classes = (CABLETWIN_OT_results_open, CABLETWIN_OT_results_choose)
