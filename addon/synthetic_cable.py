"""The cable of the asset library in a scene: found, read, and dressed.

Its shape is in the inputs of its modifier; they are read by panel and name, whatever
Blender calls them inside.
"""

from typing import Any

import bpy
from bpy.app.translations import pgettext_n as n_

ASSET = "cabletwin_asset"
"""Custom property of the library's node trees: "cable" or "ring"."""

Inputs = dict[tuple[str, str], Any]

INPUT_NAMES = (
    *(n_("Travel"), n_("Margin"), n_("Diameter (mm)"), n_("Ovality (mm)"), n_("Ovality angle")),
    *(n_("Stations"), n_("Own diameters"), n_("A position"), n_("A diameter (mm)"), n_("B position")),
    *(
        n_("B diameter (mm)"),
        n_("C position"),
        n_("C diameter (mm)"),
        n_("D position"),
        n_("D diameter (mm)"),
    ),
    *(n_("Bow"), n_("Bow (mm)"), n_("Bow azimuth"), n_("Fillet"), n_("Height (mm)"), n_("Width (mm)")),
    *(n_("Pitch"), n_("Angle"), n_("Defect 1"), n_("Defect 2"), n_("Position"), n_("Azimuth")),
    *(n_("Length (mm)"), n_("Mesh"), n_("Columns"), n_("Row spacing (mm)")),
)
"""Names of the modifier's inputs and panels, which the panel shows translated."""

_STRENGTHS = {
    "Grain": "grain",
    "Dirt": "dirt",
    "Streaks": "streaks",
    "Specks": "speckle",
    "Clouds": "mottling",
}
"""Inputs of a sheath's shader group, and the strengths of the rendered survey that mean the same."""


def asset_modifier(item: bpy.types.Object, asset: str) -> bpy.types.NodesModifier | None:
    """The modifier of an object that carries one of the library's trees."""
    for modifier in item.modifiers:
        if modifier.type == "NODES" and modifier.node_group and modifier.node_group.get(ASSET) == asset:
            return modifier
    return None


def is_cable(item: bpy.types.Object) -> bool:
    """Whether an object is a cable of the library."""
    return asset_modifier(item, "cable") is not None


def scene_cable(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The scene's cable: the chosen one, else the first that was put in."""
    chosen = scene.cabletwin.synthesise.cable
    if chosen is not None and chosen.name in scene.objects and is_cable(chosen):
        return chosen
    return next((item for item in scene.objects if is_cable(item)), None)


def sockets(modifier: bpy.types.NodesModifier) -> list[tuple[str, bpy.types.NodeTreeInterfaceSocket]]:
    """The inputs that a person sets, in order, each with the name of its panel ("" at the top)."""
    return [
        (item.parent.name if item.parent else "", item)
        for item in modifier.node_group.interface.items_tree
        if item.item_type == "SOCKET" and item.in_out == "INPUT" and item.socket_type != "NodeSocketGeometry"
    ]


def field(modifier: bpy.types.NodesModifier, socket: bpy.types.NodeTreeInterfaceSocket) -> Any:  # noqa: ANN401
    """What holds the value of an input, in its property ``value``."""
    return getattr(modifier.properties.inputs, socket.identifier)


def read_inputs(modifier: bpy.types.NodesModifier) -> Inputs:
    """All values, by panel and name."""
    return {(panel, item.name): field(modifier, item).value for panel, item in sockets(modifier)}


def write_inputs(item: bpy.types.Object, modifier: bpy.types.NodesModifier, values: Inputs) -> None:
    """Set some values, by panel and name."""
    for panel, socket in sockets(modifier):
        if (panel, socket.name) in values:
            field(modifier, socket).value = values[panel, socket.name]
    item.update_tag()


def refresh_sheath(scene: bpy.types.Scene) -> None:
    """Show the strengths on the scene's cable, where it wears a sheath of the library."""
    cable = scene_cable(scene)
    settings = scene.cabletwin.synthesise
    for slot in cable.material_slots if cable else ():
        if slot.material is None or slot.material.node_tree is None:
            continue
        for node in slot.material.node_tree.nodes:
            if node.type == "GROUP" and node.node_tree and node.node_tree.get(ASSET) == "sheath":
                for name, key in _STRENGTHS.items():
                    node.inputs[name].default_value = getattr(settings, key)
