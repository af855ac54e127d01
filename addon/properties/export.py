"""State of the area *export*."""

import bpy


class CableTwinExport(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinExport,)
