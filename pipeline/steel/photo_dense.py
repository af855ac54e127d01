"""Oriented photos to one cloud: depth maps, checked against each other and fused.

Takes oriented photos; gives points with normals, colours and sigmas in the photo frame.  One photo is held in
memory as a colour picture and a few as grey ones; depth maps are kept, at 8 bytes a cell.  Leaves out how one
depth map is made (:mod:`pipeline.steel.photo_depth`) and how maps become points
(:mod:`pipeline.steel.photo_points`).
"""

from collections import OrderedDict
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.steel.fuse_records import PhotoCloud
from pipeline.steel.photo_correlation import Image
from pipeline.steel.photo_depth import DepthMap, sweep_photo
from pipeline.steel.photo_points import angles_deg, points_of
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
    around = _jobs(photos, options)
    if not around:
        raise StageError(
            STAGE, "no two photos see the same from different places", "take photos farther apart"
        )
    pictures = _Pictures(photos, options)
    maps = _swept(photos, around, pictures, options, part(emit, 0.0, 0.85))
    parts = []
    for place, number in enumerate(around):
        emit(Event(stage=STAGE, done=850 + 150 * place // len(around), total=1000))
        parts.append(points_of(photos, maps, number, pictures.colour(number), options))
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


def _jobs(photos: OrientedPhotos, options: DepthOptions) -> dict[int, tuple[int, ...]]:
    """The photos whose depth can be told, each with its neighbours."""
    seen = photos.observations[:, 0]
    known = [n for n in range(len(photos.files)) if np.count_nonzero(seen == n) >= LEAST_SPARSE]
    around = {n: _neighbours(photos, n, options) for n in known}
    return {n: others for n, others in around.items() if others}


def _swept(
    photos: OrientedPhotos,
    around: dict[int, tuple[int, ...]],
    pictures: "_Pictures",
    options: DepthOptions,
    emit: Emit,
) -> dict[int, DepthMap]:
    """The depth map of each photo, two at once."""
    done = dict.fromkeys(around, 0.0)

    def sweep(number: int, tell: Emit) -> DepthMap:
        nearest, farthest = _range(photos, number)

        def tick(share: float) -> None:
            done[number] = share
            tell(Event(stage=STAGE, done=round(1000 * sum(done.values()) / len(done)), total=1000))

        found = sweep_photo(
            pictures.grey, photos.lens, photos.poses, number, around[number], nearest, farthest, options, tick
        )
        tick(1.0)
        return found

    maps = side_by_side([partial(sweep, n) for n in around], emit, workers_for(len(around)))
    return dict(zip(around, maps, strict=True))


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


def _range(photos: OrientedPhotos, number: int) -> tuple[float, float]:
    mine = photos.observations[photos.observations[:, 0] == number, 1]
    depth = (photos.points[mine] @ photos.poses.rotations[number].T + photos.poses.translations[number])[:, 2]
    depth = np.sort(depth[depth > 0])
    # thin members high above hold few sparse points: the nearest of them, but for a stray one, sets the range
    return 0.8 * float(depth[min(2, len(depth) - 1)]), 1.15 * float(np.percentile(depth, 99.5))
