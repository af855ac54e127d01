"""The library itself: materials, cable and ring, marked as assets, with pictures, in one .blend.  Needs bpy.

Works in an empty Blender file of its own and replaces what is open.
"""

import tempfile
from pathlib import Path

import bpy

from blend_assets.cable import cable_object, cable_tree
from blend_assets.catalogue import CABLES, ROBOTS, SHEATHS, mark, write_catalogues
from blend_assets.previews import Studio, set_input
from blend_assets.ring import ring_collection, ring_tree
from blend_assets.sheath import SHEATHS as LOOKS
from blend_assets.sheath import sheath_group, sheath_material

LIBRARY = "cabletwin.blend"
CABLE_LOOK = 3
"""The cable comes in the weathered sheath."""


def write_library(out: Path) -> Path:
    """Write the library; what lies there of an earlier one is replaced.

    Args:
        out: folder; made where it is missing.

    Returns:
        The .blend.
    """
    out.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    group = sheath_group()
    materials = [sheath_material(group, look) for look in LOOKS]
    cable = cable_object(cable_tree(), materials[CABLE_LOOK])
    ring = ring_collection(ring_tree())
    mark(
        cable,
        CABLES,
        "A stay cable with diameters, ovality, ribs, bow, bulges and dents to set in its modifier",
        ("cable", "stay", "geometry nodes"),
    )
    mark(ring, ROBOTS, "Ring of four cameras and lamps, riding on one empty", ("robot", "camera", "ring"))
    for material, look in zip(materials, LOOKS, strict=True):
        mark(material, SHEATHS, look.description, ("sheath", "cable", "procedural"))
    with tempfile.TemporaryDirectory(dir=out) as work:
        _take_pictures(Studio(Path(work)), cable, ring, materials)
        made = Path(work) / LIBRARY
        bpy.data.libraries.write(str(made), {cable, ring, *materials}, fake_user=True, compress=True)
        made.replace(out / LIBRARY)
    write_catalogues(out)
    return out / LIBRARY


def _take_pictures(
    studio: Studio,
    cable: bpy.types.Object,
    ring: bpy.types.Collection,
    materials: list[bpy.types.Material],
) -> None:
    """A piece of cable for each material, a ribbed one for the cable, and a ring on a cable."""
    piece = cable.copy()
    piece.data = cable.data.copy()
    piece.asset_clear()
    set_input(piece, "", "Travel", 0.2)
    for material in materials:
        piece.data.materials[0] = material
        studio.picture(material, [piece], (0.30, -0.20, 0.22), (0.0, 0.12, 0.0))
    set_input(piece, "Fillet", "Fillet", True)
    set_input(piece, "Fillet", "Height (mm)", 4.0)
    studio.picture(cable, [piece], (0.56, -0.42, 0.46), (0.0, 0.08, 0.0))
    set_input(piece, "Fillet", "Fillet", False)
    studio.picture(ring, [piece, *ring.objects], (0.85, -1.2, 0.68), (0.0, 0.03, 0.0))
    bpy.data.objects.remove(piece)
