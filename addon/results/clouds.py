"""Clouds of coloured points: arrays to a point cloud datablock."""

import bpy
import numpy as np

from pipeline.core.vocabulary import Array

from .materials import attribute_material

COLOUR, GAMMA = "Col", 2.2


def cloud_object(
    name: str, points: Array, colours: np.ndarray | None, radius_m: float, most: int
) -> bpy.types.Object:
    """A cloud as an object that is in no collection yet.

    Args:
        name: of object and data.
        points: (n, 3) metres.
        colours: (n, 3) uint8 sRGB, or None for a plain one.
        radius_m: of the drawn points.
        most: larger clouds are thinned evenly to at most so many points.
    """
    step = max(-(-len(points) // most), 1)
    points = np.ascontiguousarray(points[::step], dtype=np.float32)
    data = bpy.data.pointclouds.new(name)
    data.resize(len(points))
    _set(data, "position", "FLOAT_VECTOR", "vector", points)
    _set(data, "radius", "FLOAT", "value", np.full(len(points), radius_m, dtype=np.float32))
    if colours is not None:
        rgba = np.ones((len(points), 4), dtype=np.float32)
        rgba[:, :3] = colours[::step] / 255.0
        # in sRGB bytes, as the pictures are
        _set(data, COLOUR, "BYTE_COLOR", "color_srgb", rgba)
    data.materials.append(attribute_material(COLOUR if colours is not None else None))
    if colours is not None and len(colours):
        # solid views show no colours of points: the cloud has its mean one there, linear
        data.materials[0].diffuse_color = (*(np.mean(colours, axis=0) / 255.0) ** GAMMA, 1.0)
    made = bpy.data.objects.new(name, data)
    made["cabletwin_points"] = len(points)
    return made


def _set(data: bpy.types.PointCloud, name: str, kind: str, key: str, values: np.ndarray) -> None:
    attribute = data.attributes.get(name) or data.attributes.new(name, kind, "POINT")
    attribute.data.foreach_set(key, values.ravel())
