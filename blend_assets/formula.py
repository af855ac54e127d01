"""Node trees written as formulas: ``radius * (1 - s ** 2)`` instead of nodes and links.

Takes a node tree of any kind (the math nodes are the same in all); gives :class:`Value`, an output socket
with arithmetic.  Numbers stay numbers until they meet a socket.  Leaves out what the nodes mean.
"""

from __future__ import annotations

from typing import Any

import bpy

WIDTH, HEIGHT = 190.0, 170.0
"""Room of one node in the picture of the tree."""


class Formulas:
    """Writes into one node tree.

    Args:
        tree: geometry or shader nodes.
    """

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree

    def node(self, kind: str, **settings: object) -> bpy.types.Node:
        """A further node, with its settings (not its inputs)."""
        made = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(made, key, value)
        return made

    def put(self, socket: bpy.types.NodeSocket, value: Any) -> None:  # noqa: ANN401 - what a socket takes
        """Link a value to an input, or set it where it is a constant."""
        if isinstance(value, Value):
            self.tree.links.new(value.socket, socket)
        elif isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation: str, *values: Value | float, clamp: bool = False) -> Value:
        """One math node."""
        made = self.node("ShaderNodeMath", operation=operation, use_clamp=clamp)
        for socket, value in zip(made.inputs, values, strict=False):
            self.put(socket, float(value) if isinstance(value, int | float) else value)
        return Value(self, made.outputs[0])

    def wrap(self, value: Value, low: float, high: float) -> Value:
        """Into [low, high), as an angle is wrapped."""
        return self.math("WRAP", value, high, low)

    def clamp(self, value: Value, low: float, high: float) -> Value:
        """Between two bounds."""
        return self.math("MINIMUM", self.math("MAXIMUM", value, low), high)

    def cos(self, angle: Value) -> Value:
        """Cosine of radians."""
        return self.math("COSINE", angle)

    def sin(self, angle: Value) -> Value:
        """Sine of radians."""
        return self.math("SINE", angle)

    def rise(
        self, value: Value, first: Value | float, last: Value | float, kind: str = "SMOOTHERSTEP"
    ) -> Value:
        """0 up to ``first``, 1 from ``last`` on; between them Blender's own step of that kind."""
        made = self.node("ShaderNodeMapRange", interpolation_type=kind)
        made.clamp = True
        for socket, given in zip(made.inputs, (value, first, last, 0.0, 1.0), strict=False):
            self.put(socket, given)
        return Value(self, made.outputs[0])

    def at_least(self, value: Value, bound: float) -> Value:
        """1 where the value reaches the bound (an integer one), else 0."""
        return self.math("GREATER_THAN", value, bound - 0.5)

    def choose(self, switch: Value, yes: Value | float, no: Value | float) -> Value:
        """One of two numbers; the switch is 0 or 1."""
        return no + switch * (yes - no)

    def vector(self, x: Value | float, y: Value | float, z: Value | float) -> Value:
        """Three numbers as a vector."""
        made = self.node("ShaderNodeCombineXYZ")
        for socket, value in zip(made.inputs, (x, y, z), strict=True):
            self.put(socket, value)
        return Value(self, made.outputs[0])

    def parts(self, vector: Value) -> tuple[Value, Value, Value]:
        """A vector's x, y, z."""
        made = self.node("ShaderNodeSeparateXYZ")
        self.put(made.inputs[0], vector)
        x, y, z = (Value(self, socket) for socket in made.outputs)
        return x, y, z

    def tidy(self) -> None:
        """Lay the nodes out from left to right, each behind all that feed it."""
        feeds: dict[str, set[str]] = {node.name: set() for node in self.tree.nodes}
        for link in self.tree.links:
            feeds[link.to_node.name].add(link.from_node.name)
        depth: dict[str, int] = {}

        def depth_of(name: str) -> int:
            if name not in depth:
                depth[name] = 1 + max((depth_of(other) for other in feeds[name]), default=-1)
            return depth[name]

        rows: dict[int, int] = {}
        for node in self.tree.nodes:
            column = depth_of(node.name)
            node.location = (WIDTH * column, -HEIGHT * rows.get(column, 0))
            rows[column] = rows.get(column, 0) + 1


class Value:
    """An output socket that can be calculated with.

    Args:
        formulas: of its tree.
        socket: the output.
    """

    def __init__(self, formulas: Formulas, socket: bpy.types.NodeSocket) -> None:
        self.formulas, self.socket = formulas, socket

    def __add__(self, other: Value | float) -> Value:
        return self.formulas.math("ADD", self, other)

    __radd__ = __add__

    def __sub__(self, other: Value | float) -> Value:
        return self.formulas.math("SUBTRACT", self, other)

    def __rsub__(self, other: float) -> Value:
        return self.formulas.math("SUBTRACT", other, self)

    def __mul__(self, other: Value | float) -> Value:
        return self.formulas.math("MULTIPLY", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Value | float) -> Value:
        return self.formulas.math("DIVIDE", self, other)

    def __rtruediv__(self, other: float) -> Value:
        return self.formulas.math("DIVIDE", other, self)

    def __pow__(self, power: float) -> Value:
        return self.formulas.math("POWER", self, power)

    def __neg__(self) -> Value:
        return self.formulas.math("SUBTRACT", 0.0, self)
