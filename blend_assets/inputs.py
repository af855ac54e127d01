"""Inputs of a node tree as a table: name, kind, default, bounds, what it means.

Takes rows of :class:`Input` by panel, declares them in a tree's interface, and gives their values inside the
tree.  Leaves out what is made of them.
"""

import math
from dataclasses import dataclass

import bpy

from blend_assets.formula import Formulas, Value

KINDS = {
    "length": ("NodeSocketFloat", "DISTANCE"),
    "angle": ("NodeSocketFloat", "ANGLE"),
    "number": ("NodeSocketFloat", "NONE"),
    "share": ("NodeSocketFloat", "FACTOR"),
    "count": ("NodeSocketInt", "NONE"),
    "switch": ("NodeSocketBool", ""),
    "colour": ("NodeSocketColor", ""),
    "vector": ("NodeSocketVector", "NONE"),
}
"""Kind of input to Blender's type of socket and its subtype: lengths are metres, angles radians."""

ASSET = "cabletwin_asset"
"""Custom property by which a tree is known, whatever its name: "cable", "ring", "sheath"."""

Given = float | bool | tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Input:
    """One input.

    Attributes:
        name: shown; unique within its panel, with its unit where that is not the scene's.
        kind: a key of KINDS.
        default: in the unit of the kind; a tuple for colours and vectors.
        description: tip.
        low, high: bounds; None where there are none.
    """

    name: str
    kind: str
    default: Given
    description: str
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A group of inputs; where ``switch`` is set, they are used only with the panel's own switch on.

    Attributes:
        name: shown; also of the switch.
        description: tip.
        inputs: in order.
        switch: whether it has a switch, which is off by default.
    """

    name: str
    description: str
    inputs: tuple[Input, ...]
    switch: bool = False


def declare(formulas: Formulas, panels: tuple[Panel, ...]) -> dict[tuple[str, str], Value]:
    """Add the inputs to the tree's interface.

    Returns:
        (panel, input) to its value in the tree; a panel's switch is (panel, panel).
    """
    interface = formulas.tree.interface
    for panel in panels:
        # a panel without a name is the top of the interface
        parent = (
            interface.new_panel(panel.name, description=panel.description, default_closed=True)
            if panel.name
            else None
        )
        if panel.switch:
            row = Input(name=panel.name, kind="switch", default=False, description=panel.description)
            _socket(interface, row, parent).is_panel_toggle = True
        for row in panel.inputs:
            _socket(interface, row, parent)
    source = formulas.node("NodeGroupInput")
    places = [item for item in interface.items_tree if item.item_type == "SOCKET" and item.in_out == "INPUT"]
    return {
        (item.parent.name if item.parent else "", item.name): Value(formulas, socket)
        for item, socket in zip(places, source.outputs, strict=False)
    }


def degrees(angle: float) -> float:
    """An angle for a default, in radians."""
    return math.radians(angle)


def _socket(
    interface: bpy.types.NodeTreeInterface, row: Input, parent: bpy.types.NodeTreeInterfacePanel | None
) -> bpy.types.NodeTreeInterfaceSocket:
    kind, subtype = KINDS[row.kind]
    socket = interface.new_socket(row.name, description=row.description, in_out="INPUT", socket_type=kind)
    if parent is not None:
        interface.move_to_parent(socket, parent, len(parent.interface_items))
    if subtype:
        socket.subtype = subtype
    if row.low is not None:
        socket.min_value = row.low
    if row.high is not None:
        socket.max_value = row.high
    socket.default_value = row.default
    return socket
