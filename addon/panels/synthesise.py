"""The panel *Synthesise*."""

import bpy

from .base import Panel


class CABLETWIN_PT_synthesise(Panel):
    """Synthesise."""

    bl_idname = "CABLETWIN_PT_synthesise"
    bl_label = "Synthesise"
    bl_order = 9

    def draw(self, context: bpy.types.Context) -> None:
        """Nothing yet."""


classes = (CABLETWIN_PT_synthesise,)
