"""The panel *POS*."""

import bpy

from .base import Panel


class CABLETWIN_PT_pos(Panel):
    """POS."""

    bl_idname = "CABLETWIN_PT_pos"
    bl_label = "POS"
    bl_order = 2

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_pos,)
