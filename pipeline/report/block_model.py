"""One block as a textured mesh and a coloured cloud, in its own adjusted frame, and its place in the model.

Takes a block's surface and picture; gives the report's Mesh and Cloud.  What the joined model is in
:mod:`pipeline.report.model`, this is for a block.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.mosaic import Mosaic
from pipeline.cable.ring import Alignment
from pipeline.cable.surface import BlockSurface, SurfaceOptions, mesh_cells, mesh_surface
from pipeline.cable.texture import UnrolledPicture
from pipeline.core import mesh as surface_mesh
from pipeline.core.vocabulary import Array
from pipeline.report.types import Cloud, Mesh


def block_mesh(
    surface: BlockSurface, picture: UnrolledPicture, stands: NDArray[np.bool_], options: SurfaceOptions
) -> Mesh:
    """The cells that stand, (n, m) bool, as a mesh; the block's unrolled picture is its texture."""
    return textured(mesh_surface(surface, stands, options), surface, picture, options)


def textured(
    tin: surface_mesh.Mesh, surface: BlockSurface, picture: UnrolledPicture, options: SurfaceOptions
) -> Mesh:
    """A block's TIN with the block's unrolled picture."""
    rows, columns = mesh_cells(surface, options)
    azimuth, y_m = surface.azimuth[columns], surface.y_m[rows]
    row, column = np.divmod(tin.cells, len(azimuth))
    return Mesh(
        vertices=tin.vertices,
        normals=tin.normals,
        faces=tin.faces,
        uv=_picture_places(picture, azimuth[column], y_m[row]),
        texture=np.ascontiguousarray(picture.colour[..., ::-1]),
    )


def block_cloud(surface: BlockSurface, picture: UnrolledPicture) -> Cloud:
    """Every measured cell, with the colour of its place in the unrolled picture."""
    row, column = np.nonzero(surface.measured & np.isfinite(surface.radius_m))
    points = surface.points()[row, column]
    out = np.broadcast_to(surface.outward(), (*surface.radius_m.shape, 3))[row, column]
    x = np.interp(surface.azimuth[column], picture.azimuth, np.arange(len(picture.azimuth)))
    y = np.interp(surface.y_m[row], picture.y_m, np.arange(len(picture.y_m)))
    colours = np.ascontiguousarray(picture.colour[np.rint(y).astype(int), np.rint(x).astype(int), ::-1])
    return Cloud(points=points, normals=out, colours=colours)


def cable_from_block(number: int, mosaic: Mosaic, alignment: Alignment) -> Array:
    """The similarity that brings a block into the cable frame: (4, 4), metres to metres."""
    place = mosaic.placement
    scaled = place.scales[number] * place.rotations[number]
    shift = place.origins[number] + place.shifts[number] - scaled @ place.origins[number]
    matrix = np.eye(4)
    matrix[:3, :3] = alignment.rotation @ scaled
    matrix[:3, 3] = alignment.rotation @ shift + alignment.translation
    return matrix


def _picture_places(picture: UnrolledPicture, azimuth: Array, y_m: Array) -> Array:
    """Texture coordinates (n, 2) of surface places in the block's unrolled picture."""
    u = (np.interp(azimuth, picture.azimuth, np.arange(len(picture.azimuth))) + 0.5) / len(picture.azimuth)
    v = (np.interp(y_m, picture.y_m, np.arange(len(picture.y_m))) + 0.5) / len(picture.y_m)
    return np.stack([u, v], axis=1)
