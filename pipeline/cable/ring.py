"""The mosaicked model: all blocks in one closed surface about the cable's straight axis, with its picture.

Takes the blocks' cropped surfaces and pictures and their places; gives the ring (radius by azimuth and
position), the unrolled picture of the whole surface, and the rigid motion that lays the fitted axis on the y
axis.  Where blocks overlap they are blended by how squarely each looked at the surface.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.crop import Crop
from pipeline.cable.mosaic import Mosaic, MosaicBlock
from pipeline.cable.ring_picture import add_colour, brightness_factors
from pipeline.cable.surface import smoothed
from pipeline.core.events import Emit, Event
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class RingOptions:
    """Resolution of the joined model.

    Attributes:
        cell_mm: side of a cell of the radius map, raised where the blocks' own cells are hardly smaller.
        texel_mm: side of a texel of the unrolled picture; 0 takes the blocks' own.
        ends_mm: length kept beyond the first and the last frame.
    """

    cell_mm: float = field(default=0.5, metadata={"above": 0.0})
    texel_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    ends_mm: float = field(default=15.0, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """Rigid motion from the mosaic's frame to the cable's: the fitted axis becomes the y axis.

    Attributes:
        rotation: (3, 3).
        translation: (3,) metres.
    """

    rotation: Array
    translation: Array

    def apply(self, points: Array) -> Array:
        """Move points (..., 3)."""
        return points @ self.rotation.T + self.translation


@dataclass(frozen=True, kw_only=True)
class Ring:
    """The joined surface in the cable frame.

    Attributes:
        alignment: from the mosaic's frame.
        azimuth: (m,) radians, cell centres, the full turn.
        y_m: (n,) metres, cell centres.
        radius_m: (n, m), NaN where no block saw the surface.
        measured: (n, m) bool, false where a block closed a hole.
        picture: (p, q, 3) uint8 unrolled picture, blue, green, red; rows along y, columns around.
        picture_known: (p, q) bool.
        picture_y_m: (p,) metres; picture_azimuth: (q,) radians.
        texel_mm: side of a texel.
    """

    alignment: Alignment
    azimuth: Array
    y_m: Array
    radius_m: NDArray[np.floating]
    measured: NDArray[np.bool_]
    picture: NDArray[np.uint8]
    picture_known: NDArray[np.bool_]
    picture_y_m: Array
    picture_azimuth: Array
    texel_mm: float


def build_ring(
    blocks: tuple[MosaicBlock, ...],
    crops: tuple[Crop, ...],
    mosaic: Mosaic,
    travel_m: float,
    options: RingOptions,
    emit: Emit,
) -> Ring:
    """Join the placed blocks."""
    alignment = align(blocks, mosaic)
    sparse = np.concatenate([p for p, _ in _placed(blocks, mosaic, alignment, 8)])
    radius_m = float(np.median(np.hypot(sparse[:, 0], sparse[:, 2])))
    texel_mm = options.texel_mm or max(b.picture.texel_mm for b in blocks)
    azimuth, y_m = _cells(radius_m, travel_m, _cell_mm(blocks, options), options)
    picture_azimuth, picture_y = _cells(radius_m, travel_m, texel_mm, options)
    shape, picture_shape = (len(y_m), len(azimuth)), (len(picture_y), len(picture_azimuth))
    total, weight, measured = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    colour = np.zeros((*picture_shape, 3), dtype=np.float32)
    share = np.zeros(picture_shape, dtype=np.float32)
    gains = brightness_factors(blocks)
    for number, (block, crop) in enumerate(zip(blocks, crops, strict=True)):
        emit(Event(stage="ring", block=block.name, done=number, total=len(blocks)))
        square = _squareness(crop)
        points = alignment.apply(mosaic.placement.apply(number, block.surface.points()))
        _add_radius(points, block, crop, square, azimuth, y_m, (total, weight, measured))
        add_colour(points, block, crop, square, gains[number], picture_azimuth, picture_y, (colour, share))
    known = weight > 0
    return Ring(
        alignment=alignment,
        azimuth=azimuth,
        y_m=y_m,
        radius_m=np.where(known, total / np.where(known, weight, 1), np.nan).astype(np.float32),
        measured=measured > 0,
        picture=np.rint(np.clip(colour / np.maximum(share, 1e-6)[..., None], 0, 255)).astype(np.uint8),
        picture_known=share > 1e-3,
        picture_y_m=picture_y,
        picture_azimuth=picture_azimuth,
        texel_mm=texel_mm,
    )


def _cell_mm(blocks: tuple[MosaicBlock, ...], options: RingOptions) -> float:
    """Side of a cell that at least one cell of each block falls into, however it lies: else holes appear."""
    coarsest_m = max(side for block in blocks for side in block.surface.cell_m)
    return max(options.cell_mm, 1.25 * 1000 * coarsest_m)


def _cells(radius_m: float, travel_m: float, side_mm: float, options: RingOptions) -> tuple[Array, Array]:
    columns = round(2 * np.pi * radius_m / (side_mm / 1000))
    azimuth = -np.pi + (np.arange(columns) + 0.5) * 2 * np.pi / columns
    ends = options.ends_mm / 1000
    return azimuth, np.arange(-ends, travel_m + ends, side_mm / 1000)


def _placed(
    blocks: tuple[MosaicBlock, ...], mosaic: Mosaic, alignment: Alignment | None, step: int
) -> Iterator[tuple[Array, int]]:
    """Every ``step``-th kept cell of each block, smoothed, in the mosaic's or the cable's frame."""
    for number, block in enumerate(blocks):
        thin = (slice(None, None, step), slice(None, None, step))
        points = smoothed(block.surface, 2.0).points(*thin)[block.keep[thin]]
        points = mosaic.placement.apply(number, points[np.isfinite(points[:, 0])])
        yield (points if alignment is None else alignment.apply(points)), number


def align(blocks: tuple[MosaicBlock, ...], mosaic: Mosaic) -> Alignment:
    """Turn and shift the fitted axis onto the y axis, without turning about it or sliding along it."""
    points = np.concatenate([p for p, _ in _placed(blocks, mosaic, None, 12)])
    cylinder = fit_cylinder(points, direction=(0.0, 1.0, 0.0))
    along = cylinder.direction
    cosine, cross = along[1], np.cross(along, [0.0, 1.0, 0.0])
    skew = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    rotation = np.eye(3) + skew + skew @ skew / (1 + cosine)
    pivot = cylinder.point
    return Alignment(rotation=rotation, translation=np.array([0.0, pivot[1], 0.0]) - rotation @ pivot)


def _squareness(crop: Crop) -> Array:
    """Weight of each column: 1 where the camera looked square at the surface, 0 at the cut."""
    cut = crop.incidence_deg[crop.keep.any(axis=0)].max()
    return np.cos(np.deg2rad(np.minimum(90.0 * crop.incidence_deg / (cut + 1), 90.0))) ** 2 + 1e-3


def _add_radius(
    points: Array,
    block: MosaicBlock,
    crop: Crop,
    square: Array,
    azimuth: Array,
    y_m: Array,
    sums: tuple[Array, Array, Array],
) -> None:
    """Drop every kept cell of a block into the ring's cells."""
    total, weight, measured = sums
    kept = crop.keep & np.isfinite(points[..., 0])
    x, y, z = points[kept].T
    column = np.floor((np.arctan2(-z, x) + np.pi) / (2 * np.pi) * len(azimuth)).astype(int) % len(azimuth)
    row = np.rint((y - y_m[0]) / (y_m[1] - y_m[0])).astype(int)
    share = np.broadcast_to(square, kept.shape)[kept]
    seen = block.surface.measured[kept]
    inside = (row >= 0) & (row < len(y_m))
    cell = row[inside] * len(azimuth) + column[inside]
    for sums_of, values in ((total, share * np.hypot(x, z)), (weight, share), (measured, seen * 1.0)):
        sums_of += np.bincount(cell, weights=values[inside], minlength=sums_of.size).reshape(sums_of.shape)
