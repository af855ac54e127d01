"""Spheres seen in oriented photos: round, even blobs whose rays meet, of the size that the distance demands.

Takes oriented photos; gives centres and radii in the photo frame.  A sphere's outline is nearly a circle from
everywhere (its centre is shifted by less than a tenth of a pixel where it is small), and its centre is where
the outlines' centres meet: ten times sharper than a sphere through a few depths.  Leaves out spheres that the
photos cannot tell from what is around them; :mod:`pipeline.steel.photo_spheres` finds balls in the cloud.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import pixels_to_rays, project
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.fits import fit_circle
from pipeline.core.vocabulary import Array
from pipeline.steel.photo_records import OrientedPhotos

STAGE = "targets in photos"
LEVELS = (150, 165, 180, 195, 210, 225, 240)
LEAST_AREA_PX, LARGEST_SHARE = 20.0, 0.02
LEAST_ROUND = 0.80
LEAST_CONTRAST = 40.0
AGREE_PX = 2.0
SIZE_SHARE = 0.25
LEAST_PHOTOS = 3
SPOKES = 48
LEAST_OUTLINE = 0.6
"""Share of the spokes that must end on the circle."""


@dataclass(frozen=True)
class Blobs:
    """Round blobs of one photo: (n, 2) centres, (n,) radii, pixels."""

    centres: Array
    radii: Array


def find_targets(photos: OrientedPhotos, emit: Emit) -> Array:
    """(k, 4) centre and radius of spheres that at least three photos show, seen by most first.

    Raises:
        StageError: a picture cannot be read.
    """
    blobs, count = [], len(photos.files)
    for number, file in enumerate(photos.files):
        emit(Event(stage=STAGE, done=number, total=2 * count))
        picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        if picture is None:
            raise StageError(STAGE, f"{file} cannot be read as a picture", "start the photos anew")
        blobs.append(round_blobs(np.asarray(picture, dtype=np.uint8)))
    found: list[tuple[int, float, Array]] = []
    for first in range(count):
        emit(Event(stage=STAGE, done=count + first, total=2 * count))
        for second in range(first + 1, count):
            found.extend(_from_pair(photos, blobs, first, second))
    kept: list[Array] = []
    for _, _, sphere in sorted(found, key=lambda item: (-item[0], item[1])):
        if all(np.linalg.norm(sphere[:3] - other[:3]) > 2 * max(sphere[3], other[3]) for other in kept):
            kept.append(sphere)
    return np.array(kept).reshape(-1, 4)


def round_blobs(picture: NDArray[np.uint8]) -> Blobs:
    """Bright discs of a grey picture, their outline where the brightness is half of the step."""
    marks: list[tuple[float, float, float]] = []
    for level in LEVELS:
        outlines, _ = cv2.findContours(
            (picture >= level).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
        )
        for outline in outlines:
            mark = _disc(picture, outline, level)
            if mark is not None and all(np.hypot(mark[0] - m[0], mark[1] - m[1]) > m[2] for m in marks):
                marks.append(mark)
    rows = np.array(marks).reshape(-1, 3)
    return Blobs(rows[:, :2], rows[:, 2])


def _disc(
    picture: NDArray[np.uint8], outline: NDArray[np.int32], level: int
) -> tuple[float, float, float] | None:
    column, row, width, height = cv2.boundingRect(outline)
    area = cv2.contourArea(outline) + 0.5 * len(outline) + 1
    if area < LEAST_AREA_PX or area > LARGEST_SHARE * picture.size or not 0.75 < width / height < 1.33:
        return None
    radius = np.sqrt(area / np.pi)
    # a disc fills 78.5 % of its box, and all of its own circle
    if abs(area / (width * height) - np.pi / 4) > 0.13 or (width + height) / 4 * LEAST_ROUND > radius:
        return None
    edge = int(np.ceil(radius * 0.6)) + 2
    low_row, low_column = row - edge, column - edge
    if low_row < 0 or low_column < 0:
        return None
    around = picture[low_row : row + height + edge, low_column : column + width + edge].astype(float)
    if around.shape != (height + 2 * edge, width + 2 * edge):
        return None
    rows, columns = np.mgrid[: around.shape[0], : around.shape[1]]
    middle = np.array([column + (width - 1) / 2 - low_column, row + (height - 1) / 2 - low_row])
    away = np.hypot(columns - middle[0], rows - middle[1])
    inside, ring = away < 0.6 * radius, (away > radius + 1.5) & (away < radius + edge)
    bright, dark = float(np.median(around[inside])), float(np.median(around[ring]))
    if bright - dark < LEAST_CONTRAST:
        return None
    return _outlined(picture, float(column + (width - 1) / 2), float(row + (height - 1) / 2), float(radius))


def _outlined(
    picture: NDArray[np.uint8], column: float, row: float, radius: float
) -> tuple[float, float, float] | None:
    """A circle through the steepest places of the spokes: the lit side alone would pull it to the lamp."""
    turn = 2 * np.pi * np.arange(SPOKES) / SPOKES
    out = np.arange(0.4 * radius, 1.7 * radius + 1.5, 0.25)
    columns = (column + out[None] * np.cos(turn)[:, None]).astype(np.float32)
    rows = (row + out[None] * np.sin(turn)[:, None]).astype(np.float32)
    smooth = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 0.7)
    steep = np.abs(np.gradient(cv2.remap(smooth, columns, rows, cv2.INTER_CUBIC), axis=1))[:, 1:-1]
    best = np.clip(np.argmax(steep, axis=1), 1, steep.shape[1] - 2)
    spoke = np.arange(SPOKES)
    before, here, after = (steep[spoke, best + d] for d in (-1, 0, 1))
    bend = np.minimum(before - 2 * here + after, -1e-6)
    reach = out[1] + 0.25 * (best + np.clip((before - after) / (2 * bend), -0.5, 0.5))
    edge = np.stack([column + reach * np.cos(turn), row + reach * np.sin(turn)], axis=1)
    try:
        circle = fit_circle(edge, np.minimum(here, 20.0))
    except StageError:
        return None
    if (
        np.mean(np.abs(circle.distances(edge)) < 0.6) < LEAST_OUTLINE
        or not 0.6 < circle.radius / radius < 1.6
    ):
        return None
    # OpenCV's places count from the first pixel's centre, ours from its corner
    return float(circle.centre[0]) + 0.5, float(circle.centre[1]) + 0.5, float(circle.radius)


def _from_pair(
    photos: OrientedPhotos, blobs: list[Blobs], first: int, second: int
) -> list[tuple[int, float, Array]]:
    """Spheres that a blob of one photo and one of another propose and others confirm."""
    one, two = blobs[first], blobs[second]
    if not len(one.radii) or not len(two.radii):
        return []
    i, j = (part.ravel() for part in np.meshgrid(range(len(one.radii)), range(len(two.radii)), indexing="ij"))
    places, off_px = _meet(photos, [first, second], [one.centres[i], two.centres[j]])
    sizes = [_size(photos, n, places, b.radii[k]) for n, b, k in ((first, one, i), (second, two, j))]
    seen = np.all(np.array(sizes) > 0, axis=0) & (off_px < AGREE_PX)
    places, sizes = places[seen], [size[seen] for size in sizes]
    alike = np.abs(np.log(sizes[0] / sizes[1])) < SIZE_SHARE
    found = []
    for place, size in zip(places[alike], np.sqrt(sizes[0] * sizes[1])[alike], strict=True):
        sphere = _confirmed(photos, blobs, place, float(size))
        if sphere is not None:
            found.append(sphere)
    return found


def _confirmed(
    photos: OrientedPhotos, blobs: list[Blobs], place: Array, size: float
) -> tuple[int, float, Array] | None:
    """The sphere from all photos that show a blob of this size at this place."""
    seen: list[tuple[int, int]] = []
    for _ in range(2):
        seen = []
        for number, mine in enumerate(blobs):
            if not len(mine.radii):
                continue
            pixel = project(photos.lens, _in_camera(photos, number, place[None]))[0]
            away = np.linalg.norm(mine.centres - pixel, axis=1)
            nearest = int(np.argmin(np.nan_to_num(away, nan=np.inf)))
            its_size = _size(photos, number, place[None], mine.radii[nearest : nearest + 1])[0]
            if away[nearest] < AGREE_PX and abs(np.log(max(its_size, 1e-12) / size)) < SIZE_SHARE:
                seen.append((number, nearest))
        if len(seen) < LEAST_PHOTOS:
            return None
        places, off_px = _meet(photos, [n for n, _ in seen], [blobs[n].centres[k][None] for n, k in seen])
        place = places[0]
        size = float(
            np.median([_size(photos, n, place[None], blobs[n].radii[k : k + 1])[0] for n, k in seen])
        )
    if off_px[0] > AGREE_PX / 2:
        return None
    return len(seen), float(off_px[0]), np.append(place, size)


def _meet(photos: OrientedPhotos, numbers: list[int], pixels: list[Array]) -> tuple[Array, Array]:
    """Where rays meet, (n, 3), and the root mean square of how far they pass by, in pixels."""
    centres = photos.poses.centres[numbers]
    rays = []
    for number, points in zip(numbers, pixels, strict=True):
        ray = pixels_to_rays(photos.lens, points)
        ray = np.column_stack([ray, np.ones(len(ray))]) @ photos.poses.rotations[number]
        rays.append(ray / np.linalg.norm(ray, axis=1, keepdims=True))
    across = [np.eye(3) - ray[:, :, None] * ray[:, None, :] for ray in rays]
    right = sum(a @ c for a, c in zip(across, centres, strict=True))
    normal = np.asarray(sum(across)) + 1e-9 * np.eye(3)
    places = np.linalg.solve(normal, np.asarray(right)[..., None])[..., 0]
    off = []
    for number, points in zip(numbers, pixels, strict=True):
        back = project(photos.lens, _in_camera(photos, number, places))
        off.append(np.nan_to_num(np.sum((back - points) ** 2, axis=1), nan=1e9))
    return places, np.sqrt(np.mean(off, axis=0))


def _in_camera(photos: OrientedPhotos, number: int, places: Array) -> Array:
    return np.asarray(places @ photos.poses.rotations[number].T + photos.poses.translations[number])


def _size(photos: OrientedPhotos, number: int, places: Array, radii_px: Array) -> Array:
    """(n,) radius of spheres at (n, 3) places that look so large; negative behind the camera."""
    local = _in_camera(photos, number, places)
    # a sphere off the optical axis looks stretched away from it: by 1 / cos along, 1 across
    stretch = (np.linalg.norm(local, axis=1) / np.maximum(np.abs(local[:, 2]), 1e-9)) ** 0.5
    return np.asarray(radii_px / photos.lens.focal_px * local[:, 2] / stretch)
