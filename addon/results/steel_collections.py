"""The collections of a steel structure: *Steel* beside the cable's, with one child for each kind of thing.

As in ``collections``, each is found by what it says of itself, and each object by kind and name.
"""

import bpy
from bpy.app.translations import pgettext_n as n_

from . import collections

ROOT = "Steel"
STATIONS = n_("Scanner stations")
TARGETS = n_("Targets")
CLOUD = n_("Cloud")
RODS = n_("Rods")
BALLS = n_("Balls")
COLUMNS = n_("Steel columns")
ARROWS = n_("Arrows")
GROSS = n_("Gross errors")
KINDS = (STATIONS, TARGETS, CLOUD, RODS, BALLS, COLUMNS, ARROWS, GROSS)
"""In the order of the panel."""

COUNTED = set(KINDS)
"""Kinds of which a person wants to know how many there are."""

NAMES = {STATIONS: "Stations", COLUMNS: "Columns"}
"""Collections whose name in the outliner is shorter than what the panel calls them."""

_KEY = "cabletwin_steel_kind"


def emptied(scene: bpy.types.Scene, kind: str) -> bpy.types.Collection:
    """The collection of that kind with nothing in it; what only it held is freed."""
    found = existing(scene, kind)
    if found is None:
        found = bpy.data.collections.new(NAMES.get(kind, kind))
        found[_KEY] = kind
        collections.collection(scene, ROOT).children.link(found)
    _remove(list(found.objects))
    return found


def _remove(items: list[bpy.types.Object]) -> None:
    """Free objects, then data and materials that nobody else uses; one by one, 6000 rods take a minute."""
    data = {item.data for item in items if item.data is not None}
    materials = {slot.material for item in items for slot in item.material_slots if slot.material is not None}
    bpy.data.batch_remove(items)
    for unused in (data, materials):
        bpy.data.batch_remove([each for each in unused if not each.users])


def existing(scene: bpy.types.Scene, kind: str) -> bpy.types.Collection | None:
    """The scene's collection of that kind, or None."""
    root = collections.existing(scene, ROOT)
    return None if root is None else next((c for c in root.children if c.get(_KEY) == kind), None)


def objects(scene: bpy.types.Scene, kind: str) -> list[bpy.types.Object]:
    """What is of that kind; an empty list where nothing is."""
    found = existing(scene, kind)
    return [] if found is None else list(found.objects)


def named(scene: bpy.types.Scene, kind: str, name: str) -> bpy.types.Object | None:
    """The object that stands for the thing of that name, or None."""
    return next((item for item in objects(scene, kind) if item.get("cabletwin_name") == name), None)


def set_hidden(scene: bpy.types.Scene, kind: str, hidden: bool) -> None:
    """Hide or show the collection of that kind in all view layers."""
    found = existing(scene, kind)
    for view_layer in scene.view_layers:
        layer = None if found is None else collections.view_layer_collection(view_layer, found)
        if layer is not None and layer.hide_viewport != hidden:
            layer.hide_viewport = hidden
