"""State of the area *synthesise*."""

import bpy


class CableTwinSynthesise(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinSynthesise,)
