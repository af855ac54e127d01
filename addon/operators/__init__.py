"""What the buttons do, one module for each area; each gathers, calls the pipeline, and applies."""

import bpy

from . import (
    crop,
    export,
    lens,
    measure,
    mosaic,
    mosaic_pairs,
    mosaic_pick,
    pos,
    reconstruct,
    results,
    steel,
    survey,
    synthesise,
)

_MODULES = (
    *(survey, lens, pos, reconstruct, results, crop),
    *(mosaic, mosaic_pairs, mosaic_pick, measure, export, synthesise, steel),
)
_CLASSES = tuple(c for m in _MODULES for c in m.classes)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
