"""The panel *Lens*."""

import bpy

from .base import Panel


class CABLETWIN_PT_lens(Panel):
    """Lens."""

    bl_idname = "CABLETWIN_PT_lens"
    bl_label = "Lens"
    bl_order = 1

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_lens,)
