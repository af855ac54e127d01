"""Frames as Blender cameras, each with its own picture behind it, matching it to a pixel.

The pictures are the undistorted frames, and the camera the pinhole that would have taken them.
"""

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from pipeline.core.vocabulary import Array, Lens, Poses

SENSOR_MM = 36.0
CV_FROM_BLENDER = np.diag([1.0, -1.0, -1.0, 1.0])
"""Blender's camera looks along its -z with y up, photogrammetry's along z with y down."""


def camera_object(
    name: str, pinhole: Lens, rotation: Array, translation: Array, picture: Path | None, size_m: float
) -> bpy.types.Object:
    """One frame's camera as an object that is in no collection yet.

    Args:
        name: of object and data.
        pinhole: without distortion.
        rotation, translation: cam_from_world.
        picture: undistorted frame, shown behind; None where it is not there.
        size_m: of the drawn camera.
    """
    data = bpy.data.cameras.new(name)
    set_lens(data, pinhole)
    data.display_size = size_m
    if picture is not None and picture.is_file():
        background = data.background_images.new()
        background.image = bpy.data.images.load(str(picture), check_existing=True)
        background.display_depth = "BACK"
        background.alpha = 1.0
        data.show_background_images = True
    made = bpy.data.objects.new(name, data)
    made.matrix_world = Matrix(world_from_camera(rotation, translation).tolist())
    return made


def set_lens(data: bpy.types.Camera, pinhole: Lens) -> None:
    """Focal length and principal point, by the picture's longer side as Blender wants them."""
    width, height = pinhole.width_px, pinhole.height_px
    longer = max(width, height)
    data.sensor_fit = "HORIZONTAL" if width >= height else "VERTICAL"
    data.sensor_width = data.sensor_height = SENSOR_MM
    data.lens = pinhole.focal_px * SENSOR_MM / longer
    x, y = pinhole.principal_point_px
    data.shift_x = (width / 2 - x) / longer
    data.shift_y = (y - height / 2) / longer
    data.clip_start, data.clip_end = 0.005, 100.0


def world_from_camera(rotation: Array, translation: Array) -> Array:
    """(4, 4) pose of Blender's camera."""
    pose = np.eye(4)
    pose[:3, :3] = rotation.T
    pose[:3, 3] = -rotation.T @ translation
    return pose @ CV_FROM_BLENDER


def camera_objects(
    block: str, poses: Poses, pinhole: Lens, pictures: tuple[Path, ...], size_m: float
) -> list[bpy.types.Object]:
    """All frames of a block."""
    return [
        camera_object(f"{block}.{k + 1:03d}", pinhole, rotation, translation, picture, size_m)
        for k, (rotation, translation, picture) in enumerate(
            zip(poses.rotations, poses.translations, pictures, strict=True)
        )
    ]
