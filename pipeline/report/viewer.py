"""What the 3D view in the page needs, packed as text.

Takes a :class:`~pipeline.report.types.Mesh` that a browser can bear and the stations, gives the JSON record
that viewer.js reads.
"""

import base64
import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.report.pictures import data_address, jpeg_bytes, reduced
from pipeline.report.types import Mesh, Picture, StationResult

_MAX_TEXTURE_PX = 2048
MOST_VERTICES = 65_535
"""Indices are stored in 16 bits."""


@dataclass(frozen=True, kw_only=True)
class ViewerOptions:
    """How much of the model the page carries.

    Attributes:
        max_texture_px: longest side of the texture, pixels, a power of two.
        texture_quality: JPEG quality, 1 to 95.
    """

    max_texture_px: int = _MAX_TEXTURE_PX
    texture_quality: int = 82


def viewer_record(mesh: Mesh, stations: tuple[StationResult, ...], options: ViewerOptions) -> str:
    """The JSON text for the page: vertices in m (float32), normals (int8), uv and indices (uint16), rings.

    Raises:
        ValueError: the mesh has more vertices than 16 bits can count.
    """
    if len(mesh.vertices) > MOST_VERTICES:
        raise ValueError(f"the mesh has {len(mesh.vertices)} vertices, {MOST_VERTICES} at most")
    normals = np.zeros((len(mesh.vertices), 4), dtype=np.int8)
    normals[:, :3] = np.rint(127 * mesh.normals)
    record = {
        "vertices": _packed(mesh.vertices.astype("<f4")),
        "normals": _packed(normals),
        "uv": _packed(np.rint(65535 * np.clip(mesh.uv, 0, 1)).astype("<u2")),
        "indices": _packed(mesh.faces.astype("<u2")),
        "texture": _texture_address(mesh.texture, options),
        "stations": [_ring(station) for station in stations if station.circle_radius_mm > 0],
    }
    # A "<" could end the script element that holds the record.
    return json.dumps(record, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _ring(station: StationResult) -> dict[str, Any]:
    x_mm, z_mm = station.circle_centre_mm
    return {
        "name": station.name,
        "text": f"{station.diameter_mm:.2f} mm",
        "centre": [x_mm / 1000, station.position_m, z_mm / 1000],
        "radius": station.circle_radius_mm / 1000,
    }


def _texture_address(texture: Picture, options: ViewerOptions) -> str:
    """The texture as JPEG, both sides a power of two: older WebGL smooths only such ones when far away."""
    image = reduced(texture, options.max_texture_px)
    width, height = (min(options.max_texture_px, 1 << (side - 1).bit_length()) for side in image.size)
    image = image.resize((width, height), Image.Resampling.LANCZOS)
    return data_address(jpeg_bytes(image, options.texture_quality), "image/jpeg")


def _packed(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
