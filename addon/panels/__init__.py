"""The sidebar tab, one panel for each area, in the order of the work.  They draw; nothing more."""

import bpy

from . import crop, export, lens, measure, mosaic, pos, reconstruct, results, steel, survey, synthesise

_MODULES = (survey, lens, pos, reconstruct, results, crop, mosaic, measure, export, synthesise, steel)
_CLASSES = tuple(c for m in _MODULES for c in m.classes)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
