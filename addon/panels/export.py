"""The panel *Export*: which files, where to, and the report itself."""

import bpy

from ..properties.export import FILES
from .base import Panel


class CABLETWIN_PT_export(Panel):
    """Export."""

    bl_idname = "CABLETWIN_PT_export"
    bl_label = "Export"
    bl_order = 8

    def draw(self, context: bpy.types.Context) -> None:
        """The report's button, a check box for each file, the folder."""
        data = context.scene.cabletwin
        if not data.results.finished:
            self.layout.label(text="The run is not finished yet", icon="INFO")
            return
        row = self.layout.row()
        row.scale_y = 1.4
        row.operator("cabletwin.export_report", icon="URL")
        column = self.layout.column(align=True)
        for key, _ in FILES:
            column.prop(data.export, key)
        column = self.layout.column()
        column.prop(data.export, "folder", text="")
        row = column.row(align=True)
        row.operator("cabletwin.export_files", icon="EXPORT")
        row.operator("cabletwin.export_folder", icon="FILE_FOLDER")


classes = (CABLETWIN_PT_export,)
