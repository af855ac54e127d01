"""Depth maps to points: each confirmed by its neighbours, their depths averaged, with normal and sigma.

Takes oriented photos and their depth maps; gives the points of one photo.  Leaves out the maps
(photo_depth.py) and which photos are neighbours (photo_dense.py).

Source of the check (a depth must come back from the neighbour's own depth map): G. Egnal and R. P. Wildes,
"Detecting binocular half-occlusions", IEEE PAMI 24(8), 2002.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import project
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import PhotoCloud
from pipeline.steel.photo_depth import DepthMap, grid_pixels, grid_rays
from pipeline.steel.photo_records import DepthOptions, OrientedPhotos

LEAST_SAME = 0.32
"""Share of the cells around one that must lie on its surface, for a normal."""
REACH = 2
"""Cells each way that make up a window."""
NEARLY = 0.01
"""Depths of cells so many cells apart that differ by less than this share for each are one surface's."""
LEAST_COSINE = 0.2
"""No surface counts as met more obliquely than this: its normal is too rough to tell."""


def angles_deg(points: Array, first: Array, second: Array) -> Array:
    """(n,) angle at which the rays from two centres meet in (n, 3) points."""
    a, b = first - points, second - points
    cosine = np.sum(a * b, axis=-1) / np.maximum(
        np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1), 1e-300
    )
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def points_of(
    photos: OrientedPhotos,
    maps: dict[int, DepthMap],
    number: int,
    picture: NDArray[np.uint8],
    options: DepthOptions,
) -> PhotoCloud:
    """The points of one photo that its neighbours confirm, their depths averaged with theirs.

    Args:
        photos: all of them.
        maps: the depth map of each photo that has one.
        number: of the photo.
        picture: (h, w, 3) its blue-green-red.
        options: see there.
    """
    mine = maps[number]
    rays = grid_rays(photos.lens, mine.step_px)
    rotation, translation = photos.poses.rotations[number], photos.poses.translations[number]
    valid = np.isfinite(mine.depth)
    found = _averaged(photos, maps, number, rays, valid, options)
    normals, same, uneven = _normals(rays * found.depth[..., None], valid)
    confirmed = found.maps > min(options.least_agreeing, len(mine.neighbours))
    kept = valid & confirmed & (same >= LEAST_SAME)
    place = (rays * found.depth[..., None] - translation) @ rotation
    # along the ray a surface that is met obliquely is uneven by more
    uneven = uneven / np.maximum(np.abs(np.sum(normals * rays, axis=2)), LEAST_COSINE)
    sigma = _sigmas(found, share_behind(found.depth, valid), uneven, photos.lens.focal_px, options)
    sigma *= np.linalg.norm(rays, axis=2)
    pixel = grid_pixels(photos.lens, mine.step_px).astype(np.int64)
    colour = picture[pixel[..., 1], pixel[..., 0]][..., ::-1]
    return PhotoCloud(
        points=place[kept],
        normals=(normals @ rotation)[kept],
        colours=np.ascontiguousarray(colour[kept]),
        sigmas=sigma[kept],
    )


@dataclass(frozen=True, kw_only=True)
class _Averaged:
    """What all maps say of one photo's cells, (h, w) each: mean depth, photo units, along the camera's z; the
    standard deviation of one map's; how many maps; sine of the widest angle at which rays meet."""

    depth: Array
    scatter: Array
    maps: NDArray[np.int64]
    widest: Array


def _averaged(
    photos: OrientedPhotos,
    maps: dict[int, DepthMap],
    number: int,
    rays: Array,
    valid: NDArray[np.bool_],
    options: DepthOptions,
) -> _Averaged:
    mine, poses = maps[number], photos.poses
    depth = np.where(valid, mine.depth, 1.0).astype(float)
    places = (rays * depth[..., None] - poses.translations[number]) @ poses.rotations[number]
    total, square = depth.copy(), depth**2
    count, widest = np.ones(depth.shape, dtype=np.int64), np.zeros(depth.shape)
    for other in {*mine.neighbours, *(n for n, m in maps.items() if number in m.neighbours)} & maps.keys():
        seen_at, agrees = _returned(photos, maps[other], number, other, places, valid, options)
        total[agrees] += seen_at[agrees]
        square[agrees] += seen_at[agrees] ** 2
        count[agrees] += 1
        angle = np.sin(np.radians(angles_deg(places, poses.centres[number], poses.centres[other])))
        widest = np.where(agrees, np.maximum(widest, angle), widest)
    mean = total / count
    scatter = np.sqrt(np.maximum(square - count * mean**2, 0) / np.maximum(count - 1, 1))
    return _Averaged(depth=mean, scatter=scatter, maps=count, widest=widest)


def _sigmas(found: _Averaged, behind: Array, uneven: Array, focal_px: float, options: DepthOptions) -> Array:
    """(h, w) standard deviation of each depth, photo units: four things that do not know of each other.

    What the best correlation is worth; how far the maps that saw the place differ (two maps compare the same
    two pictures, so half of them count and their mean is no better than one); where part of the window shows
    what is behind, that the cell itself may be behind and have the depth of an edge half a window away; and
    where the window's own surface is bent, as on a ball or a rod, that the peak belongs to any place in it.

    Args:
        found: depths.
        behind: share of the window that lies behind the cell's own surface.
        uneven: root mean square of that surface off its plane through the cell, along the camera's z.
        focal_px: of the lens.
        options: see there.
    """
    per_px = found.depth / focal_px / np.maximum(found.widest, 0.02)
    slid = 0.5 * options.window_px / np.sqrt(3) * behind * per_px
    matched = options.matching_sigma_px * per_px
    return np.sqrt(matched**2 + 0.5 * found.scatter**2 + slid**2 + uneven**2)


def share_behind(depth: Array, valid: NDArray[np.bool_], reach: int = REACH) -> Array:
    """(h, w) share of the cells around each that lie behind its surface.

    Where nothing is known there is taken to be what lies farthest beside it.  A nearer thing in the window
    does no such harm: it would have given the cell its own depth ("foreground fattening": D. Scharstein and
    R. Szeliski, "A taxonomy and evaluation of dense two-frame stereo correspondence algorithms", IJCV 47(1),
    2002).

    Args:
        depth: (h, w) along the camera's z.
        valid: (h, w) where it is known.
        reach: cells each way.
    """
    known = np.where(valid, depth, 0.0).astype(np.float32)
    around = np.ones((4 * reach + 1, 4 * reach + 1), dtype=np.uint8)
    farthest = np.where(valid, known, cv2.dilate(known, around))
    padded = np.pad(farthest, reach)
    height, width = valid.shape
    behind = np.zeros(valid.shape)
    for down in range(2 * reach + 1):
        for right in range(2 * reach + 1):
            behind += padded[down : down + height, right : right + width] > (1 + NEARLY * reach) * known
    return np.where(valid, behind / (2 * reach + 1) ** 2, 0.0)


def _returned(
    photos: OrientedPhotos,
    theirs: DepthMap,
    number: int,
    other: int,
    places: Array,
    valid: NDArray[np.bool_],
    options: DepthOptions,
) -> tuple[Array, NDArray[np.bool_]]:
    """Depth in this photo that another's map gives at the same place, and whether it is the same place."""
    lens, poses = photos.lens, photos.poses
    step = theirs.step_px
    in_other = places @ poses.rotations[other].T + poses.translations[other]
    pixel = project(lens, in_other.reshape(-1, 3)).reshape(*places.shape[:2], 2) / step
    columns, rows = np.floor(np.nan_to_num(pixel, nan=-1)).astype(np.int64).transpose(2, 0, 1)
    height, width = theirs.depth.shape
    inside = valid & (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    columns, rows = np.clip(columns, 0, width - 1), np.clip(rows, 0, height - 1)
    found = theirs.depth[rows, columns]
    # their cell lies a little beside the place: on this photo's ray the depth is off as theirs is
    ratio = found / np.where(in_other[..., 2] > 0, in_other[..., 2], np.nan)
    base = np.linalg.norm(poses.centres[number] - poses.centres[other])
    own = (places @ poses.rotations[number].T + poses.translations[number])[..., 2]
    off_px = np.abs(1 - ratio) * base * lens.focal_px / np.maximum(in_other[..., 2], 1e-9)
    agrees = inside & (off_px < options.agree_px * np.sqrt(step))
    return np.where(agrees, own * ratio, 0.0), agrees


def _normals(places: Array, valid: NDArray[np.bool_], reach: int = REACH) -> tuple[Array, Array, Array]:
    """Normals (h, w, 3) towards the camera from neighbours at nearly the same depth, these's share, and their
    root mean square distance from the plane through the cell, (h, w) each."""
    height, width = valid.shape
    count, first, second = np.zeros(valid.shape), np.zeros(places.shape), np.zeros((*places.shape, 3))
    depth = np.where(valid, places[..., 2], np.nan)
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            here = (slice(max(-down, 0), height - max(down, 0)), slice(max(-right, 0), width - max(right, 0)))
            there = (
                slice(max(down, 0), height - max(-down, 0)),
                slice(max(right, 0), width - max(-right, 0)),
            )
            with np.errstate(invalid="ignore"):
                near = np.abs(depth[there] / depth[here] - 1) < NEARLY * reach
            away = np.where(near[..., None], places[there] - places[here], 0.0)
            count[here] += near
            first[here] += away
            second[here] += away[..., :, None] * away[..., None, :]
    same = count / (2 * reach + 1) ** 2
    known = valid & (same >= LEAST_SAME)
    mean = first / np.maximum(count, 1)[..., None]
    moments = second / np.maximum(count, 1)[..., None, None] - mean[..., :, None] * mean[..., None, :]
    normals, uneven = np.zeros_like(places), np.zeros(valid.shape)
    values, vectors = np.linalg.eigh(moments[known])
    normals[known] = vectors[:, :, 0]
    uneven[known] = np.sqrt(np.maximum(values[:, 0], 0) + np.sum(mean[known] * normals[known], axis=1) ** 2)
    away_from_camera = np.sum(normals * places, axis=2) > 0
    return np.where(away_from_camera[..., None], -normals, normals), same, uneven
