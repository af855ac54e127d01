"""The panel *Measure*."""

import bpy

from .base import Panel


class CABLETWIN_PT_measure(Panel):
    """Measure."""

    bl_idname = "CABLETWIN_PT_measure"
    bl_label = "Measure"
    bl_order = 7

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_measure,)
