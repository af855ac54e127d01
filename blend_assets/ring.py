"""The robot's ring: hardware as geometry nodes, and real cameras and lamps that ride on it.

Everything hangs on one empty, the ring's middle on the axis, so that moving this along +y moves the robot.  A
camera at azimuth a looks at the axis, the travel pointing to the right of its image; lamps stand half-way
between cameras, as in a rendered survey.
"""

import math

import bpy
from mathutils import Matrix, Vector

from blend_assets.formula import Formulas, Value
from blend_assets.inputs import ASSET, Input, Panel, declare

TREE = "CableTwin ring"
CAMERAS, STANDOFF_M = 4, 0.3
FOCAL_SHARE = 0.75
"""Focal length by image width: 720 px of 960."""
LAMP_W = 1.0

RING = (
    Panel(
        name="",
        description="",
        inputs=(
            Input(
                name="Cameras",
                kind="count",
                default=CAMERAS,
                low=1,
                high=16,
                description="Cameras around the cable",
            ),
            Input(
                name="Stand-off",
                kind="length",
                default=STANDOFF_M,
                low=0.01,
                description="From the centre of a camera to the axis of the cable",
            ),
            Input(
                name="Camera size",
                kind="length",
                default=0.05,
                low=0.001,
                description="Of a camera's housing",
            ),
        ),
    ),
)


def ring_tree() -> bpy.types.GeometryNodeTree:
    """The node tree of the hardware: a hoop behind the cameras, a housing for each, a lamp between two."""
    tree = bpy.data.node_groups.new(TREE, "GeometryNodeTree")
    tree.is_modifier = True
    tree[ASSET] = "ring"
    tree.description = "The robot's ring around the axis +Y"
    formulas = Formulas(tree)
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Body", in_out="INPUT", socket_type="NodeSocketMaterial")
    tree.interface.new_socket("Lamp", in_out="INPUT", socket_type="NodeSocketMaterial")
    inputs = declare(formulas, RING)
    size = inputs["", "Camera size"]
    hoop_radius = inputs["", "Stand-off"] + 0.9 * size
    parts = [
        _dressed(formulas, _hoop(formulas, hoop_radius, size), inputs["", "Body"]),
        _dressed(formulas, _housings(formulas, inputs, hoop_radius, size), inputs["", "Body"]),
        _dressed(formulas, _lamps(formulas, inputs, hoop_radius, size), inputs["", "Lamp"]),
    ]
    joined = formulas.node("GeometryNodeJoinGeometry")
    for part in parts:
        formulas.put(joined.inputs["Geometry"], part)
    formulas.put(formulas.node("NodeGroupOutput").inputs["Geometry"], joined.outputs["Geometry"])
    formulas.tidy()
    return tree


def ring_collection(tree: bpy.types.GeometryNodeTree, cameras: int = CAMERAS) -> bpy.types.Collection:
    """The ring as a collection: the empty, the hardware, cameras and lamps."""
    made = bpy.data.collections.new("Robot ring")
    middle = bpy.data.objects.new("Robot ring", None)
    middle.empty_display_type, middle.empty_display_size = "ARROWS", 0.08
    hardware = bpy.data.objects.new("Ring hardware", bpy.data.meshes.new("Ring hardware"))
    modifier = hardware.modifiers.new("Ring", "NODES")
    modifier.node_group = tree
    sockets = {item.name: item.identifier for item in tree.interface.items_tree if item.item_type == "SOCKET"}
    for name, material in (("Body", _body_material()), ("Lamp", _lamp_material())):
        getattr(modifier.properties.inputs, sockets[name]).value = material
    riders = [hardware]
    for number in range(cameras):
        azimuth = math.tau * number / cameras
        riders += [_camera(number, azimuth), _light(number, azimuth + math.pi / cameras)]
    made.objects.link(middle)
    for rider in riders:
        rider.parent = middle
        made.objects.link(rider)
    return made


def looking_at_axis(azimuth: float, standoff_m: float) -> Matrix:
    """Place of a Blender camera or lamp (x right, y up, z backward); +y of the cable is at its right."""
    outward = Vector((math.cos(azimuth), 0.0, -math.sin(azimuth)))
    right = Vector((0.0, 1.0, 0.0))
    up = outward.cross(right)
    placed = Matrix((right, up, outward)).transposed().to_4x4()
    placed.translation = standoff_m * outward
    return placed


def _camera(number: int, azimuth: float) -> bpy.types.Object:
    data = bpy.data.cameras.new(f"Block{number + 1}")
    data.sensor_width, data.lens, data.display_size = 36.0, 36.0 * FOCAL_SHARE, 0.06
    made = bpy.data.objects.new(f"Block{number + 1}", data)
    made.matrix_local = looking_at_axis(azimuth, STANDOFF_M)
    return made


def _light(number: int, azimuth: float) -> bpy.types.Object:
    data = bpy.data.lights.new(f"Lamp{number + 1}", "POINT")
    data.energy, data.shadow_soft_size = LAMP_W, 0.02
    made = bpy.data.objects.new(f"Lamp{number + 1}", data)
    made.matrix_local = looking_at_axis(azimuth, STANDOFF_M)
    return made


def _hoop(formulas: Formulas, radius: Value, size: Value) -> bpy.types.NodeSocket:
    """A flat hoop around y."""
    circle = formulas.node("GeometryNodeCurvePrimitiveCircle")
    formulas.put(circle.inputs["Resolution"], 96)
    formulas.put(circle.inputs["Radius"], radius)
    section = formulas.node("GeometryNodeCurvePrimitiveQuadrilateral")
    formulas.put(section.inputs["Width"], 0.16 * size)
    formulas.put(section.inputs["Height"], 0.9 * size)
    swept = formulas.node("GeometryNodeCurveToMesh")
    formulas.put(swept.inputs["Curve"], circle.outputs["Curve"])
    formulas.put(swept.inputs["Profile Curve"], section.outputs["Curve"])
    turned = formulas.node("GeometryNodeTransform")
    formulas.put(turned.inputs["Geometry"], swept.outputs["Mesh"])
    formulas.put(turned.inputs["Rotation"], (math.pi / 2.0, 0.0, 0.0))
    return turned.outputs["Geometry"]


def _housings(
    formulas: Formulas, inputs: dict[tuple[str, str], Value], radius: Value, size: Value
) -> bpy.types.NodeSocket:
    """A box with a lens for each camera; the lens ends where the camera's centre is."""
    box = formulas.node("GeometryNodeMeshCube")
    formulas.put(box.inputs["Size"], formulas.vector(0.7 * size, size, 0.7 * size))
    barrel = formulas.node("GeometryNodeMeshCylinder")
    formulas.put(barrel.inputs["Vertices"], 32)
    formulas.put(barrel.inputs["Radius"], 0.24 * size)
    formulas.put(barrel.inputs["Depth"], 0.5 * size)
    aimed = formulas.node("GeometryNodeTransform")
    formulas.put(aimed.inputs["Geometry"], barrel.outputs["Mesh"])
    formulas.put(aimed.inputs["Rotation"], (0.0, math.pi / 2.0, 0.0))
    formulas.put(aimed.inputs["Translation"], formulas.vector(-0.5 * size, 0.0, 0.0))
    body = formulas.node("GeometryNodeJoinGeometry")
    formulas.put(body.inputs["Geometry"], aimed.outputs["Geometry"])
    formulas.put(body.inputs["Geometry"], box.outputs["Mesh"])
    return _around(formulas, body.outputs["Geometry"], inputs["", "Cameras"], radius - 0.1 * size, 0.0)


def _lamps(
    formulas: Formulas, inputs: dict[tuple[str, str], Value], radius: Value, size: Value
) -> bpy.types.NodeSocket:
    """A flat lamp half-way between cameras."""
    lamp = formulas.node("GeometryNodeMeshCube")
    formulas.put(lamp.inputs["Size"], formulas.vector(0.2 * size, 0.8 * size, 0.8 * size))
    return _around(formulas, lamp.outputs["Mesh"], inputs["", "Cameras"], radius - 0.2 * size, 0.5)


def _around(
    formulas: Formulas, item: bpy.types.NodeSocket, count: Value, radius: Value, first: float
) -> bpy.types.NodeSocket:
    """``count`` copies around y, the first at ``first`` steps from azimuth 0, each with its x outward."""
    points = formulas.node("GeometryNodePoints")
    index = Value(formulas, formulas.node("GeometryNodeInputIndex").outputs[0])
    azimuth = (index + first) * math.tau / count
    place = formulas.vector(radius * formulas.cos(azimuth), 0.0, -(radius * formulas.sin(azimuth)))
    formulas.put(points.inputs["Count"], count)
    formulas.put(points.inputs["Position"], place)
    turn = formulas.node("FunctionNodeEulerToRotation")
    formulas.put(turn.inputs[0], formulas.vector(0.0, azimuth, 0.0))
    copies = formulas.node("GeometryNodeInstanceOnPoints")
    formulas.put(copies.inputs["Points"], points.outputs[0])
    formulas.put(copies.inputs["Instance"], item)
    formulas.put(copies.inputs["Rotation"], turn.outputs[0])
    real = formulas.node("GeometryNodeRealizeInstances")
    formulas.put(real.inputs[0], copies.outputs["Instances"])
    return real.outputs[0]


def _dressed(formulas: Formulas, part: bpy.types.NodeSocket, material: Value) -> bpy.types.NodeSocket:
    made = formulas.node("GeometryNodeSetMaterial")
    formulas.put(made.inputs["Geometry"], part)
    formulas.put(made.inputs["Material"], material)
    return made.outputs["Geometry"]


def _body_material() -> bpy.types.Material:
    made = bpy.data.materials.new("Ring body")
    surface = next(n for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
    surface.inputs["Base Color"].default_value = (0.8, 0.24, 0.03, 1.0)
    surface.inputs["Roughness"].default_value = 0.4
    made.diffuse_color = (0.8, 0.24, 0.03, 1.0)
    return made


def _lamp_material() -> bpy.types.Material:
    made = bpy.data.materials.new("Ring lamp")
    surface = next(n for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
    surface.inputs["Base Color"].default_value = (0.9, 0.9, 0.85, 1.0)
    surface.inputs["Emission Color"].default_value = (1.0, 0.97, 0.9, 1.0)
    surface.inputs["Emission Strength"].default_value = 2.0
    made.diffuse_color = (1.0, 0.97, 0.9, 1.0)
    return made
