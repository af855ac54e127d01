"""The panel *Export*."""

import bpy

from .base import Panel


class CABLETWIN_PT_export(Panel):
    """Export."""

    bl_idname = "CABLETWIN_PT_export"
    bl_label = "Export"
    bl_order = 8

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_export,)
