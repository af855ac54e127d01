"""The add-on in Simplified Chinese: each area's strings in a module of its own."""

import bpy

from . import (
    common,
    crop,
    export,
    lens,
    measure,
    mosaic,
    pos,
    reconstruct,
    results,
    steel,
    survey,
    synthesise,
)

_AREAS = (common, reconstruct, results, survey, lens, pos, crop, mosaic, measure, export, synthesise, steel)
_CONTEXTS = ("*", "Operator")


def catalogue() -> dict[str, dict[tuple[str, str], str]]:
    """What Blender wants: locale to (context, English) to text."""
    texts = {english: chinese for area in _AREAS for english, chinese in area.ZH.items()}
    return {"zh_HANS": {(context, e): c for context in _CONTEXTS for e, c in texts.items()}}


def register() -> None:
    """Give Blender the texts."""
    bpy.app.translations.register(__name__, catalogue())


def unregister() -> None:
    """Take them back."""
    bpy.app.translations.unregister(__name__)
