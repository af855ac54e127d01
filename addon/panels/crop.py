"""The panel *Crop*."""

import bpy

from .base import Panel


class CABLETWIN_PT_crop(Panel):
    """Crop."""

    bl_idname = "CABLETWIN_PT_crop"
    bl_label = "Crop"
    bl_order = 5

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_crop,)
