"""The cable as geometry nodes: the surface of ``synth.surface``, written once more, as a node tree.

Takes the modifier's inputs (:mod:`blend_assets.cable_inputs`); gives an open tube along +y in metres, in the
cable frame, with the UV map ``unrolled`` (girth and length, 0 to 1; it turns with the ribs).  Azimuth a is
(cos a, 0, -sin a).  The material is the object's, so that one can be dropped on it.
"""

import itertools
import math

import bpy

from blend_assets.cable_inputs import CABLE, DEFECTS, STATIONS
from blend_assets.formula import Formulas, Value
from blend_assets.inputs import ASSET, declare

TREE = "CableTwin cable"
UV = "unrolled"
RIB_COLUMNS = 0.4
"""Share of the columns that lie across the ribs."""

SEAM_M = 1.0e-6
"""Points of the seam nearer than this are one; in single precision they differ by some 1e-8 m."""

Inputs = dict[tuple[str, str], Value]


def cable_tree() -> bpy.types.GeometryNodeTree:
    """The node tree of the cable's modifier."""
    tree = bpy.data.node_groups.new(TREE, "GeometryNodeTree")
    tree.is_modifier = True
    tree[ASSET] = "cable"
    tree.description = "A stay cable along +Y, in the frame of the survey"
    formulas = Formulas(tree)
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    inputs = declare(formulas, CABLE)
    grid, across, along = _grid(formulas, inputs)
    start, length = -inputs["", "Margin"], inputs["", "Travel"] + 2.0 * inputs["", "Margin"]
    y = start + along * length
    azimuth = _columns(formulas, inputs, across) + _twist(inputs, y)
    radius = _radius(formulas, inputs, azimuth, y)
    x0, z0 = _axis(formulas, inputs, y)
    place = formulas.vector(x0 + radius * formulas.cos(azimuth), y, z0 - radius * formulas.sin(azimuth))
    unrolled = formulas.vector(azimuth / math.tau, along, 0.0)
    _finish(formulas, inputs, grid, across, place, unrolled)
    formulas.tidy()
    return tree


def cable_object(tree: bpy.types.GeometryNodeTree, material: bpy.types.Material) -> bpy.types.Object:
    """An object that carries the modifier."""
    data = bpy.data.meshes.new("Cable")
    data.from_pydata([(0, 0, 0)], [], [])  # what holds the material: see _finish
    data.materials.append(material)
    made = bpy.data.objects.new("Cable", data)
    made.modifiers.new("Cable", "NODES").node_group = tree
    return made


def _grid(formulas: Formulas, inputs: Inputs) -> tuple[bpy.types.NodeSocket, Value, Value]:
    """A flat grid and the place of its points in it, 0 to 1 around and along."""
    length_mm = 1000.0 * (inputs["", "Travel"] + 2.0 * inputs["", "Margin"])
    rows = formulas.math("CEIL", length_mm / inputs["Mesh", "Row spacing (mm)"])
    grid = formulas.node("GeometryNodeMeshGrid")
    formulas.put(grid.inputs["Size X"], 1.0)
    formulas.put(grid.inputs["Size Y"], 1.0)
    formulas.put(grid.inputs["Vertices X"], inputs["Mesh", "Columns"] + 1.0)
    formulas.put(grid.inputs["Vertices Y"], rows + 1.0)
    place = formulas.node("GeometryNodeInputPosition")
    across, along, _ = formulas.parts(Value(formulas, place.outputs[0]))
    return grid.outputs["Mesh"], across + 0.5, along + 0.5


def _columns(formulas: Formulas, inputs: Inputs, across: Value) -> Value:
    """Azimuth of a column, before the twist: even, or with ribs denser across these."""
    radius_mm = 1000.0 * _nominal_radius(formulas, inputs)
    rib = inputs["Fillet", "Width (mm)"] / radius_mm
    half_turns = 2.0 * across
    which = formulas.math("FLOOR", half_turns)
    within = half_turns - which
    on_rib = rib * (formulas.math("MINIMUM", within, RIB_COLUMNS) / RIB_COLUMNS - 0.5)
    behind = (math.pi - rib) * formulas.math("MAXIMUM", within - RIB_COLUMNS, 0.0) / (1.0 - RIB_COLUMNS)
    dense = inputs["Fillet", "Angle"] + math.pi * which + on_rib + behind
    return formulas.choose(inputs["Fillet", "Fillet"], dense, math.tau * across)


def _twist(inputs: Inputs, y: Value) -> Value:
    """The grid turns with the ribs."""
    return inputs["Fillet", "Fillet"] * (math.tau * y / inputs["Fillet", "Pitch"])


def _nominal_radius(formulas: Formulas, inputs: Inputs) -> Value:
    """Metres; widths around the girth refer to it: the stations' mean where they set the diameter."""
    count = inputs["Stations", "Stations"]
    total: Value | float = 0.0
    for number, name in enumerate(STATIONS, start=1):
        total = total + formulas.at_least(count, number) * inputs["Stations", f"{name} diameter (mm)"]
    mean = total / formulas.math("MAXIMUM", count, 1.0)
    return formulas.choose(_profiled(formulas, inputs), mean, inputs["", "Diameter (mm)"]) / 2000.0


def _profiled(formulas: Formulas, inputs: Inputs) -> Value:
    """1 where the stations set the diameter."""
    return formulas.at_least(inputs["Stations", "Stations"], 1) * inputs["Stations", "Own diameters"]


def _mean_radius(formulas: Formulas, inputs: Inputs, y: Value) -> Value:
    """Metres: the first station's, and each further one's step, which has risen in full where it lies."""
    count = inputs["Stations", "Stations"]
    first = STATIONS[0]
    diameter = inputs["Stations", f"{first} diameter (mm)"]
    for number, (before, name) in enumerate(itertools.pairwise(STATIONS), start=2):
        step = inputs["Stations", f"{name} diameter (mm)"] - inputs["Stations", f"{before} diameter (mm)"]
        risen = formulas.rise(
            y, inputs["Stations", f"{before} position"], inputs["Stations", f"{name} position"]
        )
        diameter = diameter + formulas.at_least(count, number) * step * risen
    return formulas.choose(_profiled(formulas, inputs), diameter, inputs["", "Diameter (mm)"]) / 2000.0


def _radius(formulas: Formulas, inputs: Inputs, azimuth: Value, y: Value) -> Value:
    """Metres, about the local axis, in the plane across y."""
    turned = 2.0 * (azimuth - inputs["", "Ovality angle"])
    radius = _mean_radius(formulas, inputs, y) + inputs["", "Ovality (mm)"] / 4000.0 * formulas.cos(turned)
    nominal = _nominal_radius(formulas, inputs)
    radius = radius + inputs["Fillet", "Fillet"] * _rib(formulas, inputs, nominal, azimuth, y)
    for name in DEFECTS:
        radius = radius + inputs[name, name] * _defect(formulas, inputs, name, nominal, azimuth, y)
    return radius


def _rib(formulas: Formulas, inputs: Inputs, nominal: Value, azimuth: Value, y: Value) -> Value:
    """Height over the sheath in metres: h (1 + cos(2 pi s / w)) / 2 within half a width of the nearer rib."""
    turned = azimuth - inputs["Fillet", "Angle"] - math.tau * y / inputs["Fillet", "Pitch"]
    nearer = formulas.wrap(turned, -math.pi / 2.0, math.pi / 2.0)
    share = formulas.clamp(1000.0 * nearer * nominal / inputs["Fillet", "Width (mm)"], -0.5, 0.5)
    return inputs["Fillet", "Height (mm)"] / 2000.0 * (1.0 + formulas.cos(math.tau * share))


def _defect(formulas: Formulas, inputs: Inputs, name: str, nominal: Value, azimuth: Value, y: Value) -> Value:
    """Height over the sheath in metres, h (1 - s^2)^3 within the ellipse s < 1."""
    arc = formulas.wrap(azimuth - inputs[name, "Azimuth"], -math.pi, math.pi) * nominal
    along = (y - inputs[name, "Position"]) * 2000.0 / inputs[name, "Length (mm)"]
    around = arc * 2000.0 / inputs[name, "Width (mm)"]
    inside = formulas.math("MAXIMUM", 1.0 - along * along - around * around, 0.0)
    return inputs[name, "Height (mm)"] / 1000.0 * (inside * inside * inside)


def _axis(formulas: Formulas, inputs: Inputs, y: Value) -> tuple[Value, Value]:
    """x and z of the bowed axis in metres."""
    share = y / inputs["", "Travel"]
    rise = inputs["Bow", "Bow (mm)"] / 250.0 * share * (1.0 - share)
    azimuth = inputs["Bow", "Bow azimuth"]
    return rise * formulas.cos(azimuth), -(rise * formulas.sin(azimuth))


def _finish(
    formulas: Formulas,
    inputs: Inputs,
    grid: bpy.types.NodeSocket,
    across: Value,
    place: Value,
    unrolled: Value,
) -> None:
    """UV first, as long as the grid is flat; then the shape, a closed seam, and the object's own material."""
    stored = formulas.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT2", domain="CORNER")
    formulas.put(stored.inputs["Geometry"], grid)
    formulas.put(stored.inputs["Name"], UV)
    formulas.put(stored.inputs["Value"], unrolled)
    shaped = formulas.node("GeometryNodeSetPosition")
    formulas.put(shaped.inputs["Geometry"], stored.outputs["Geometry"])
    formulas.put(shaped.inputs["Position"], place)
    # the object's mesh is one point that brings the material slots; it goes when it has done so
    joined = formulas.node("GeometryNodeJoinGeometry")
    source = next(node for node in formulas.tree.nodes if node.bl_idname == "NodeGroupInput")
    formulas.put(joined.inputs["Geometry"], shaped.outputs["Geometry"])
    formulas.put(joined.inputs["Geometry"], source.outputs["Geometry"])
    dressed = formulas.node("GeometryNodeSetMaterialIndex")
    formulas.put(dressed.inputs["Geometry"], joined.outputs["Geometry"])
    formulas.put(dressed.inputs["Material Index"], 0)
    neighbours = formulas.node("GeometryNodeInputMeshVertexNeighbors")
    alone = 1.0 - formulas.at_least(Value(formulas, neighbours.outputs["Face Count"]), 1)
    cable = formulas.node("GeometryNodeDeleteGeometry")
    formulas.put(cable.inputs["Geometry"], dressed.outputs["Geometry"])
    formulas.put(cable.inputs["Selection"], alone)
    smooth = formulas.node("GeometryNodeSetShadeSmooth")
    formulas.put(smooth.inputs[0], _closed(formulas, cable.outputs["Geometry"]))
    result = formulas.node("NodeGroupOutput")
    formulas.put(result.inputs["Geometry"], smooth.outputs[0])


def _closed(formulas: Formulas, tube: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """The tube with its first and last column made one; only its borders are searched."""
    edge = formulas.node("GeometryNodeInputMeshEdgeNeighbors")
    on_border = 1.0 - formulas.at_least(Value(formulas, edge.outputs["Face Count"]), 2)
    merged = formulas.node("GeometryNodeMergeByDistance")
    formulas.put(merged.inputs["Geometry"], tube)
    formulas.put(merged.inputs["Selection"], on_border)
    formulas.put(merged.inputs["Distance"], SEAM_M)
    return merged.outputs["Geometry"]
