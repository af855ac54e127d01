"""What the buttons do, one module for each area; each gathers, calls the pipeline, and applies."""

import bpy

from . import reconstruct, results, survey

_MODULES = (survey, reconstruct, results)
_CLASSES = tuple(c for m in _MODULES for c in m.classes)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
