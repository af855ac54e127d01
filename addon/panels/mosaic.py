"""The panel *Mosaic*."""

import bpy

from .base import Panel


class CABLETWIN_PT_mosaic(Panel):
    """Mosaic."""

    bl_idname = "CABLETWIN_PT_mosaic"
    bl_label = "Mosaic"
    bl_order = 6

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_mosaic,)
