"""Operators of the export: copy a finished run's files, open its report and its folder."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as translated

from pipeline.core.errors import StageError

from .base import Operator


class CABLETWIN_OT_export_files(Operator):
    """Copy the chosen files to the chosen folder."""

    bl_idname = "cabletwin.export_files"
    bl_label = "Export"
    bl_description = "Copy the chosen files of the finished run to the folder"
    bl_options = {"REGISTER"}

    def work(self, context: bpy.types.Context) -> None:
        """Copy, each whole or not at all."""
        from pipeline.copies import copy_results

        export = context.scene.cabletwin.export
        if not export.folder:
            raise StageError("export", "no folder is chosen", "choose where the copies go")
        copied = copy_results(shown_run(context.scene), export.names(), Path(bpy.path.abspath(export.folder)))
        text = translated("{} files copied to {}").format(len(copied), copied[0].parent)
        self.report({"INFO"}, text)


class CABLETWIN_OT_export_report(Operator):
    """Open the report in the browser."""

    bl_idname = "cabletwin.export_report"
    bl_label = "Open Report"
    bl_description = "Open the report in the web browser; it needs no network"
    bl_options = {"REGISTER"}

    def work(self, context: bpy.types.Context) -> None:
        """Open the run's own page."""
        from pipeline.copies import finished_file

        page = finished_file(shown_run(context.scene), "report.html")
        bpy.ops.wm.url_open(url=page.absolute().as_uri())


class CABLETWIN_OT_export_folder(Operator):
    """Open the folder in the file manager."""

    bl_idname = "cabletwin.export_folder"
    bl_label = "Open Folder"
    bl_description = "Show the exported files in the file manager; before an export, the run's own"
    bl_options = {"REGISTER"}

    def work(self, context: bpy.types.Context) -> None:
        """Open what is there."""
        chosen = context.scene.cabletwin.export.folder
        folder = Path(bpy.path.abspath(chosen)) if chosen else shown_run(context.scene)
        if not folder.is_dir():
            raise StageError("export", f"{folder} is not there", "export first, or choose another folder")
        bpy.ops.wm.path_open(filepath=str(folder))


def shown_run(scene: bpy.types.Scene) -> Path:
    """The run folder whose results the scene shows.

    Raises:
        StageError: none is shown.
    """
    folder = scene.cabletwin.results.folder
    if not folder:
        raise StageError("export", "no results are shown", "open a run folder in the panel Results")
    return Path(bpy.path.abspath(folder))


classes = (CABLETWIN_OT_export_files, CABLETWIN_OT_export_report, CABLETWIN_OT_export_folder)
