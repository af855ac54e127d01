"""The collections of a survey: one under the scene, with one child for each kind of thing.

A collection is found by what it says of itself and not by its name, which a person may change.
"""

import bpy
from bpy.app.translations import pgettext_n as n_

ROOT = "CableTwin"
SETUP = n_("Setup")
PATHS = n_("Camera paths")
SPARSE = n_("Sparse points")
CAMERAS = n_("Cameras")
DENSE = n_("Dense cloud")
BLOCKS = n_("Block meshes")
MOSAIC = n_("Mosaic")
STATIONS = n_("Stations")
PAIRS = n_("Pairs")
CABLE = n_("Synthetic cable")
RING = n_("Robot ring")
KINDS = (SETUP, PATHS, SPARSE, CAMERAS, DENSE, BLOCKS, MOSAIC, STATIONS, PAIRS)
"""In the order of the work; the panel shows them translated, the outliner as they are."""

COUNTED = {CAMERAS, BLOCKS, STATIONS}
"""Kinds of which a person wants to know how many there are."""

_KEY = "cabletwin_kind"


def collection(scene: bpy.types.Scene, kind: str) -> bpy.types.Collection:
    """The scene's collection of that kind; made where it is not there yet."""
    return _child(_child(scene.collection, ROOT), kind)


def existing(scene: bpy.types.Scene, kind: str) -> bpy.types.Collection | None:
    """The scene's collection of that kind, or None."""
    root = _find(scene.collection, ROOT)
    return None if root is None else _find(root, kind)


def own_objects(scene: bpy.types.Scene) -> set[bpy.types.Object]:
    """Everything that the extension has put into the scene."""
    root = _find(scene.collection, ROOT)
    return set() if root is None else set(root.all_objects)


def emptied(scene: bpy.types.Scene, kind: str) -> bpy.types.Collection:
    """The collection of that kind with nothing in it; what only it held is freed."""
    found = collection(scene, kind)
    for item in list(found.objects):
        remove(item)
    return found


def remove(item: bpy.types.Object) -> None:
    """Free an object, and its data, materials and their pictures where nobody else uses them."""
    data = item.data
    bpy.data.objects.remove(item)
    if data is None or data.users:
        return
    materials = [m for m in getattr(data, "materials", ()) if m is not None]
    nodes = [n for m in materials if m.node_tree is not None for n in m.node_tree.nodes]
    pictures = {n.image for n in nodes if n.type == "TEX_IMAGE" and n.image is not None}
    bpy.data.batch_remove([data])
    for unused in (materials, pictures):
        bpy.data.batch_remove([each for each in unused if not each.users])


def set_hidden(scene: bpy.types.Scene, kind: str, hidden: bool) -> bool:
    """Hide or show what is of that kind, in all view layers; gives whether that changed anything."""
    wanted = existing(scene, kind)
    changed = False
    for view_layer in scene.view_layers:
        layer = None if wanted is None else view_layer_collection(view_layer, wanted)
        if layer is not None and layer.hide_viewport != hidden:
            layer.hide_viewport = hidden
            changed = True
    return changed


def view_layer_collection(
    view_layer: bpy.types.ViewLayer, wanted: bpy.types.Collection
) -> bpy.types.LayerCollection | None:
    """The place of a collection in a view layer, where it can be hidden."""
    waiting = [view_layer.layer_collection]
    while waiting:
        layer = waiting.pop()
        if layer.collection == wanted:
            return layer
        waiting.extend(layer.children)
    return None


def _child(parent: bpy.types.Collection, kind: str) -> bpy.types.Collection:
    found = _find(parent, kind)
    if found is None:
        found = bpy.data.collections.new(kind)
        found[_KEY] = kind
        parent.children.link(found)
    return found


def _find(parent: bpy.types.Collection, kind: str) -> bpy.types.Collection | None:
    return next((c for c in parent.children if c.get(_KEY) == kind), None)
