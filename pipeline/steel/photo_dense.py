"""Oriented photos to one cloud: depth maps, checked against each other and fused.

Takes oriented photos; gives points with normals, colours and sigmas in the photo frame.  One photo is held in
memory as a colour picture and a few as grey ones; depth maps are kept, at 8 bytes a cell.  Leaves out how one
depth map is made (:mod:`pipeline.steel.photo_depth`).

Source of the check (a depth must come back from the neighbour's own depth map): G. Egnal and R. P. Wildes,
"Detecting binocular half-occlusions", IEEE PAMI 24(8), 2002.
"""

from collections import OrderedDict
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import project
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import PhotoCloud
from pipeline.steel.photo_depth import DepthMap, Image, grid_pixels, grid_rays, sweep_photo
from pipeline.steel.photo_records import DepthOptions, OrientedPhotos

STAGE = "dense"
HELD_PICTURES = 24
LEAST_SPARSE = 15
"""A photo with fewer sparse points has no depth range worth searching."""


def densify(photos: OrientedPhotos, options: DepthOptions, emit: Emit) -> PhotoCloud:
    """Make the cloud.

    Raises:
        StageError: no photo has neighbours, or nothing agrees.
    """
    jobs = [
        n
        for n in range(len(photos.files))
        if np.count_nonzero(photos.observations[:, 0] == n) >= LEAST_SPARSE
    ]
    around = {n: _neighbours(photos, n, options) for n in jobs}
    jobs = [n for n in jobs if around[n]]
    if not jobs:
        raise StageError(
            STAGE, "no two photos see the same from different places", "take photos farther apart"
        )
    pictures = _Pictures(photos, options)
    told = part(emit, 0.0, 0.85)
    done = dict.fromkeys(jobs, 0.0)

    def sweep(number: int, tell: Emit) -> DepthMap:
        nearest, farthest = _range(photos, number)

        def tick(share: float) -> None:
            done[number] = share
            tell(Event(stage=STAGE, done=round(1000 * sum(done.values()) / len(jobs)), total=1000))

        found = sweep_photo(
            pictures.grey, photos.lens, photos.poses, number, around[number], nearest, farthest, options, tick
        )
        tick(1.0)
        return found

    swept = side_by_side([partial(sweep, n) for n in jobs], told, workers_for(len(jobs)))
    maps = dict(zip(jobs, swept, strict=True))
    parts = []
    for place, number in enumerate(jobs):
        emit(Event(stage=STAGE, done=850 + 150 * place // len(jobs), total=1000))
        parts.append(_points_of(photos, maps, number, pictures, options))
    cloud = PhotoCloud(
        points=np.concatenate([p.points for p in parts]),
        normals=np.concatenate([p.normals for p in parts]),
        colours=np.concatenate([p.colours for p in parts]),
        sigmas=np.concatenate([p.sigmas for p in parts]),
    )
    if not len(cloud):
        raise StageError(
            STAGE, "no depth is confirmed by a second photo", "take sharper photos with more overlap"
        )
    emit(Event(stage=STAGE, done=1000, total=1000))
    return cloud


class _Pictures:
    """Grey pictures, blurred to the grid; only the latest stay in memory."""

    def __init__(self, photos: OrientedPhotos, options: DepthOptions) -> None:
        self._files, self._held = photos.files, OrderedDict[int, Image]()
        self._blur = 0.35 * options.step_px

    def colour(self, number: int) -> NDArray[np.uint8]:
        """Blue-green-red."""
        picture = cv2.imread(str(self._files[number]), cv2.IMREAD_COLOR)
        if picture is None:
            raise StageError(
                STAGE, f"{self._files[number]} cannot be read as a picture", "start the photos anew"
            )
        return np.asarray(picture, dtype=np.uint8)

    def grey(self, number: int) -> Image:
        """Float32, blurred."""
        held = self._held.get(number)
        if held is None:
            image = cv2.cvtColor(self.colour(number), cv2.COLOR_BGR2GRAY).astype(np.float32)
            held = np.asarray(cv2.GaussianBlur(image, (0, 0), max(self._blur, 0.3)), dtype=np.float32)
            self._held[number] = held
            # a thread may have dropped one at the same time: never expect a certain one to be there
            while len(self._held) > HELD_PICTURES:
                self._held.pop(next(iter(self._held)), None)
        return held


def _neighbours(photos: OrientedPhotos, number: int, options: DepthOptions) -> tuple[int, ...]:
    """Photos that share sparse points with this one, seen at angles near the best."""
    seen = {n: photos.observations[photos.observations[:, 0] == n, 1] for n in range(len(photos.files))}
    centres, worth, angles = photos.poses.centres, {}, {}
    for other in seen:
        common = np.intersect1d(seen[number], seen[other])
        if other == number or len(common) < LEAST_SPARSE:
            continue
        angle = angles_deg(photos.points[common], centres[number], centres[other])
        angles[other] = angle
        fit = np.exp(-0.5 * (np.log(np.maximum(angle, 0.1) / options.best_angle_deg) / 0.7) ** 2)
        worth[other] = float(np.sum(fit * (angle > options.least_angle_deg)))
    # half of them as near as can be, for what is close; half at the best angle, for what is far
    usual = {n: float(np.median(angles[n])) for n in worth if worth[n] > 0}
    close = sorted(usual, key=lambda n: (usual[n], n))[: (options.neighbours + 1) // 2]
    rest = sorted(usual.keys() - set(close), key=lambda n: (-worth[n], n))
    return tuple([*close, *rest][: options.neighbours])


def angles_deg(points: Array, first: Array, second: Array) -> Array:
    """(n,) angle at which the rays from two centres meet in (n, 3) points."""
    a, b = first - points, second - points
    cosine = np.sum(a * b, axis=-1) / np.maximum(
        np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1), 1e-300
    )
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def _range(photos: OrientedPhotos, number: int) -> tuple[float, float]:
    mine = photos.observations[photos.observations[:, 0] == number, 1]
    depth = (photos.points[mine] @ photos.poses.rotations[number].T + photos.poses.translations[number])[:, 2]
    depth = np.sort(depth[depth > 0])
    # thin members high above hold few sparse points: the nearest of them, but for a stray one, sets the range
    return 0.8 * float(depth[min(2, len(depth) - 1)]), 1.15 * float(np.percentile(depth, 99.5))


def _points_of(
    photos: OrientedPhotos, maps: dict[int, DepthMap], number: int, pictures: _Pictures, options: DepthOptions
) -> PhotoCloud:
    """The points of one photo that its neighbours confirm, their depths averaged with theirs."""
    mine, lens = maps[number], photos.lens
    rays = grid_rays(lens, mine.step_px)
    rotation, translation = photos.poses.rotations[number], photos.poses.translations[number]
    valid = np.isfinite(mine.depth)
    depth = np.where(valid, mine.depth, 1.0).astype(float)
    places = (rays * depth[..., None] - translation) @ rotation
    total, count, widest = depth.copy(), np.ones(depth.shape, dtype=np.int64), np.zeros(depth.shape)
    for other in {*mine.neighbours, *(n for n, m in maps.items() if number in m.neighbours)} & maps.keys():
        seen_at, agrees = _returned(photos, maps[other], number, other, places, valid, options)
        total[agrees] += seen_at[agrees]
        count[agrees] += 1
        angle = np.sin(
            np.radians(angles_deg(places, photos.poses.centres[number], photos.poses.centres[other]))
        )
        widest = np.where(agrees, np.maximum(widest, angle), widest)
    mean = total / count
    normals, known = _normals(rays * mean[..., None], valid)
    kept = valid & (count > min(options.least_agreeing, len(mine.neighbours))) & known
    place = (rays * mean[..., None] - translation) @ rotation
    score = np.clip(np.nan_to_num(mine.score, nan=0.5), 0.5, 0.99)
    # the noise of a shift by correlation goes with the root of what does not correlate
    matching_px = options.matching_sigma_px * np.sqrt((1 - score**2) / score**2 / (1 - 0.9**2) * 0.81)
    length = mean * np.linalg.norm(rays, axis=2)
    sigma = np.maximum(matching_px, options.matching_sigma_px / 3) / lens.focal_px * length
    pixel = grid_pixels(lens, mine.step_px).astype(np.int64)
    colour = pictures.colour(number)[pixel[..., 1], pixel[..., 0]][..., ::-1]
    return PhotoCloud(
        points=place[kept],
        normals=(normals @ rotation)[kept],
        colours=np.ascontiguousarray(colour[kept]),
        sigmas=(sigma / np.maximum(widest, 0.02))[kept],
    )


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


def _normals(places: Array, valid: NDArray[np.bool_], reach: int = 2) -> tuple[Array, NDArray[np.bool_]]:
    """Normals (h, w, 3) towards the camera from neighbours at nearly the same depth, and where known."""
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
                near = np.abs(depth[there] / depth[here] - 1) < 0.01 * reach
            away = np.where(near[..., None], places[there] - places[here], 0.0)
            count[here] += near
            first[here] += away
            second[here] += away[..., :, None] * away[..., None, :]
    known = valid & (count >= (2 * reach + 1) ** 2 // 3)
    mean = first / np.maximum(count, 1)[..., None]
    moments = second / np.maximum(count, 1)[..., None, None] - mean[..., :, None] * mean[..., None, :]
    normals = np.zeros_like(places)
    normals[known] = np.linalg.eigh(moments[known])[1][:, :, 0]
    away_from_camera = np.sum(normals * places, axis=2) > 0
    return np.where(away_from_camera[..., None], -normals, normals), known
