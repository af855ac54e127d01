"""The state of the add-on: one property group for each area, all under ``Scene.cabletwin``."""

import bpy

from . import block, crop, export, job, lens, measure, mosaic, pos, results, run, steel, survey, synthesise

_MODULES = (block, survey, lens, pos, run, results, crop, mosaic, measure, export, synthesise, steel, job)


class CableTwinProperties(bpy.types.PropertyGroup):
    """Everything that a scene knows of its survey."""

    survey: bpy.props.PointerProperty(type=survey.CableTwinSurvey)
    lens: bpy.props.PointerProperty(type=lens.CableTwinLens)
    pos: bpy.props.PointerProperty(type=pos.CableTwinPos)
    run: bpy.props.PointerProperty(type=run.CableTwinRun)
    results: bpy.props.PointerProperty(type=results.CableTwinResults)
    crop: bpy.props.PointerProperty(type=crop.CableTwinCrop)
    mosaic: bpy.props.PointerProperty(type=mosaic.CableTwinMosaic)
    measure: bpy.props.PointerProperty(type=measure.CableTwinMeasure)
    export: bpy.props.PointerProperty(type=export.CableTwinExport)
    synthesise: bpy.props.PointerProperty(type=synthesise.CableTwinSynthesise)
    steel: bpy.props.PointerProperty(type=steel.CableTwinSteel)


_CLASSES = (*(c for m in _MODULES for c in m.classes), CableTwinProperties)


def register() -> None:
    """Register the groups and hang them on scene and window manager."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.cabletwin = bpy.props.PointerProperty(type=CableTwinProperties)
    bpy.types.WindowManager.cabletwin_job = bpy.props.PointerProperty(type=job.CableTwinJob)


def unregister() -> None:
    """Take them away again."""
    del bpy.types.WindowManager.cabletwin_job
    del bpy.types.Scene.cabletwin
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
