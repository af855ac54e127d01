"""The textured mesh as one binary glTF 2.0 file (.glb).

Takes a :class:`~pipeline.report.types.Mesh`, gives bytes; layout after the glTF 2.0 specification (Khronos,
sections 3 and 4).  Written by hand and not by trimesh, which would store the texture as a large PNG or as a
JPEG of low quality.  Coordinates stay those of the cable frame, metres: glTF's "up" is +y, our direction of
travel, so the cable stands upright in a glTF viewer.
"""

import json
import struct

import numpy as np
from numpy.typing import NDArray

from pipeline.report.pictures import jpeg_bytes, reduced
from pipeline.report.types import Mesh

_FLOAT, _UINT32 = 5126, 5125
_VERTEX_DATA, _INDEX_DATA = 34962, 34963
_CLAMP_TO_EDGE, _LINEAR, _LINEAR_MIPMAP = 33071, 9729, 9987
# What current graphics hardware takes as one texture.
_MAX_TEXTURE_PX = 8192


def glb_bytes(mesh: Mesh) -> bytes:
    """The mesh with normals, texture coordinates and a JPEG texture as a .glb file."""
    positions = mesh.vertices.astype("<f4")
    chunks: list[tuple[bytes, int | None]] = [
        (positions.tobytes(), _VERTEX_DATA),
        (mesh.normals.astype("<f4").tobytes(), _VERTEX_DATA),
        (mesh.uv.astype("<f4").tobytes(), _VERTEX_DATA),
        (mesh.faces.astype("<u4").tobytes(), _INDEX_DATA),
        (jpeg_bytes(reduced(mesh.texture, _MAX_TEXTURE_PX), quality=95), None),
    ]
    views, blob = _pack(chunks)
    tree = _tree(positions, len(mesh.faces), views, len(blob))
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    header = struct.pack("<4sII", b"glTF", 2, total)
    json_head = struct.pack("<I4s", len(text), b"JSON")
    blob_head = struct.pack("<I4s", len(blob), b"BIN\0")
    return b"".join([header, json_head, text, blob_head, blob])


def _pack(chunks: list[tuple[bytes, int | None]]) -> tuple[list[dict[str, int]], bytes]:
    """Lay the chunks out one after the other, each starting at a multiple of four bytes."""
    views: list[dict[str, int]] = []
    blob = bytearray()
    for payload, target in chunks:
        view = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(payload)}
        views.append(view if target is None else view | {"target": target})
        blob += payload + b"\0" * (-len(payload) % 4)
    return views, bytes(blob)


def _tree(
    positions: NDArray[np.float32], face_count: int, views: list[dict[str, int]], size: int
) -> dict[str, object]:
    """The JSON part: one mesh, one material, one texture."""

    def accessor(view: int, count: int, kind: str, component: int = _FLOAT) -> dict[str, object]:
        return {"bufferView": view, "componentType": component, "count": count, "type": kind}

    box = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    texture = {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.9}
    sampler = {"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP}
    wrap = {"wrapS": _CLAMP_TO_EDGE, "wrapT": _CLAMP_TO_EDGE}
    return {
        "asset": {"version": "2.0", "generator": "CableTwin"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "cable", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 3, "material": 0}]}],
        "materials": [{"name": "surface", "pbrMetallicRoughness": texture, "doubleSided": True}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [sampler | wrap],
        "images": [{"bufferView": 4, "mimeType": "image/jpeg"}],
        "accessors": [
            accessor(0, len(positions), "VEC3") | box,
            accessor(1, len(positions), "VEC3"),
            accessor(2, len(positions), "VEC2"),
            accessor(3, 3 * face_count, "SCALAR", _UINT32),
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": size}],
    }
