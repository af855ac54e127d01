"""A Cycles camera that traces the division model ray by ray, and the proof that a render used it.

Needs bpy.  Cycles compiles the shader through the module ``oslquery``, which lies in the bpy wheel's inner
site-packages; without it Cycles prints an error and renders a wrong picture, hence the check of every frame.
"""

import sys
from pathlib import Path

import bpy
import mathutils
import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array, Lens
from synth.lens import lambda_per_focal, rays

SHADER_FILE = Path(__file__).with_name("division_camera.osl")
BLENDER_FROM_CAMERA = np.diag([1.0, -1.0, -1.0])  # Blender: x right, y up, z backward
RAY_TOLERANCE_PX = 0.02  # Cycles meets the closed form within 0.001 px
RAYS_CHECKED_MIN = 50


def make_camera(scene: bpy.types.Scene) -> bpy.types.Object:
    """Add the camera to the scene and make it the active one.

    Raises:
        StageError: the shader was not compiled.
    """
    _let_cycles_find_oslquery()
    data = bpy.data.cameras.new("division")
    camera = bpy.data.objects.new("division", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    data.type = "CUSTOM"
    data.custom_mode = "INTERNAL"
    text = bpy.data.texts.new(SHADER_FILE.name)
    text.write(SHADER_FILE.read_text(encoding="ascii"))
    data.custom_shader = text  # assigning compiles
    if not data.custom_bytecode_hash or "focal_px" not in data.cycles_custom:
        raise StageError(
            "lens",
            f"this Blender's Cycles did not compile {SHADER_FILE.name} (it lacks Open Shading Language)",
            "use a Blender from blender.org, or from the command line `make setup`",
        )
    return camera


def set_lens(camera: bpy.types.Object, lens: Lens) -> None:
    """Give the camera a block's lens."""
    values = camera.data.cycles_custom
    values["focal_px"] = float(lens.focal_px)
    values["width_px"] = float(lens.width_px)
    values["height_px"] = float(lens.height_px)
    values["principal_x_px"], values["principal_y_px"] = map(float, lens.principal_point_px)
    values["k"] = float(lambda_per_focal(lens))
    camera.data.update_tag()


def camera_matrix(rotation: Array, translation: Array) -> mathutils.Matrix:
    """Blender's world matrix of a camera with the pose cam_from_world (rotation (3, 3), translation (3,))."""
    world_from_blender = np.eye(4)
    world_from_blender[:3, :3] = rotation.T @ BLENDER_FROM_CAMERA
    world_from_blender[:3, 3] = -rotation.T @ translation
    return mathutils.Matrix(world_from_blender.tolist())


def check_rays(lens: Lens, rotation: Array, translation: Array, hits_in_world: Array, frame: str) -> None:
    """Verify that a picture was traced through the lens: every hit lies on its pixel's closed-form ray.

    Args:
        lens: the block's true lens.
        rotation, translation: true cam_from_world.
        hits_in_world: (height, width, 3) first hit of the ray through each pixel's centre, 0 where none.
        frame: name for the message.

    Raises:
        StageError: the render did not use the lens, or shows no cable.
    """
    rows, columns = np.nonzero(np.any(hits_in_world != 0.0, axis=-1))
    if len(rows) < RAYS_CHECKED_MIN:
        raise StageError("lens", f"{frame} shows no cable", "check robot.standoff_m and the lens")
    points = hits_in_world[rows, columns].astype(float) @ rotation.T + translation
    expected = rays(lens, np.stack([columns + 0.5, rows + 0.5], axis=-1))
    off_px = lens.focal_px * np.linalg.norm(points[:, :2] / points[:, 2:] - expected[:, :2], axis=1)
    worst_px = float(np.percentile(off_px, 99.0))
    if not worst_px < RAY_TOLERANCE_PX:
        raise StageError(
            "lens",
            f"{frame} was not traced through the division lens (rays off by {worst_px:.3g} px)",
            "reinstall bpy with `make setup`; the picture was not kept",
        )


def _let_cycles_find_oslquery() -> None:
    inner = Path(bpy.utils.system_resource("SCRIPTS")).parent / "python" / "lib"
    for folder in inner.glob("python3*/site-packages"):
        if str(folder) not in sys.path:
            sys.path.append(str(folder))
