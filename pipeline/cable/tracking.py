"""Tracking of surface points through a block's frames, each from the frame that sees it best.

Takes undistorted frames, predicted orientations and the cable's rough radius; gives image points, sub-pixel.
A template is cut once, where the camera stands nearest to the point, and is found again in every frame that
sees it: the robot glides along the cable, so the surface only shifts in the picture, and no error adds up
along the track.  Lighting travels with the robot; normalising each frame to its local mean and contrast
takes it out.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.cylinder_view import azimuths, image_points, meet_cylinder
from pipeline.core.vocabulary import Array, Lens, Poses

Gray = NDArray[np.uint8]
PYRAMID_LEVELS = 2


@dataclass(frozen=True, kw_only=True)
class TrackOptions:
    """How points are chosen and followed.

    Attributes:
        points_per_frame: new points in each frame, spread over its own strip of surface.
        limb_deg: points further than this from the camera's azimuth are left out.
        window_px: side of the template.
        round_trip_px: tracking there and back must end this close to the start.
        difference: largest mean difference of the normalised templates, in grey values of 255.
        normalise_px: radius of the local mean and contrast.
    """

    points_per_frame: int = field(default=260, metadata={"minimum": 1})
    limb_deg: float = field(default=58.0, metadata={"above": 0.0, "maximum": 85.0})
    window_px: int = field(default=21, metadata={"minimum": 5})
    round_trip_px: float = field(default=0.25, metadata={"above": 0.0})
    difference: float = field(default=18.0, metadata={"above": 0.0})
    normalise_px: float = field(default=9.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Track:
    """The points that one frame gave birth to, and where the frames saw them.

    Attributes:
        home: index of the frame in which they were chosen.
        starts: (m, 3) rough positions on the cable, metres.
        frame: (k,) int64 frame of each measurement.
        point: (k,) int64 point of each measurement, 0 to m - 1.
        pixels: (k, 2) in the undistorted frame.
    """

    home: int
    starts: Array
    frame: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array


def normalise(image: Gray, radius_px: float) -> Gray:
    """Take out local mean and contrast: 128 + 40 standard deviations, (h, w) uint8."""
    values = image.astype(np.float32)
    mean = cv2.GaussianBlur(values, (0, 0), radius_px)
    spread = cv2.GaussianBlur((values - mean) ** 2, (0, 0), radius_px)
    scaled = 128 + 40 * (values - mean) / np.sqrt(spread + 4.0)
    return np.clip(scaled, 0, 255).astype(np.uint8)


class NormalisedFrames:
    """Normalised frames, made when asked for; only the latest ``keep`` stay in memory.

    Args:
        read: gives the grey frame k, (h, w) uint8.
    """

    def __init__(self, read: Callable[[int], Gray], options: TrackOptions, keep: int = 64) -> None:
        self._read, self._options, self._keep = read, options, keep
        self._held: OrderedDict[int, Gray] = OrderedDict()

    def __getitem__(self, frame: int) -> Gray:
        if frame not in self._held:
            self._held[frame] = normalise(self._read(frame), self._options.normalise_px)
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        self._held.move_to_end(frame)
        return self._held[frame]


class Tracker:
    """Follows the surface of one block.

    Args:
        frames: undistorted.
        lens: of the undistorted frames.
        poses: predicted orientations.
        azimuth_deg: of the block's camera.
        radius_m: rough radius of the cable.
    """

    def __init__(
        self,
        frames: NormalisedFrames,
        lens: Lens,
        poses: Poses,
        azimuth_deg: float,
        radius_m: float,
        options: TrackOptions,
    ) -> None:
        self._lens, self._poses, self._radius_m, self._options = lens, poses, radius_m, options
        self._azimuth = np.deg2rad(azimuth_deg)
        self._frames = frames

    def track(self, home: int) -> Track:
        """Choose points in frame ``home`` and follow them both ways until they leave the picture."""
        return self.follow(home, *self._choose(home))

    def follow(self, home: int, pixels: Array, starts: Array) -> Track:
        """Follow given points, (m, 2) pixels in frame ``home`` and (m, 3) rough places, both ways."""
        everything = np.arange(len(starts))
        found = [(np.full(len(starts), home), everything, pixels)]
        for step in (1, -1):
            found.extend(self._follow(home, step, pixels, starts))
        frame, point, where = (np.concatenate(part) for part in zip(*found, strict=True))
        return Track(home=home, starts=starts, frame=frame, point=point, pixels=where)

    def _choose(self, home: int) -> tuple[Array, Array]:
        """Corners on the strip of surface that frame ``home`` sees best: (m, 2) pixels, (m, 3) points."""
        options, image = self._options, self._frames[home]
        found = cv2.goodFeaturesToTrack(
            image, 20 * options.points_per_frame, 0.01, minDistance=3, blockSize=7, useHarrisDetector=False
        )
        if found is None:
            return np.zeros((0, 2)), np.zeros((0, 3))
        refined = found[:, 0, :].astype(np.float64) + 0.5
        points = meet_cylinder(self._lens, *self._pose(home), refined, self._radius_m)
        turned = np.angle(np.exp(1j * (azimuths(points) - self._azimuth)))
        first, last = self._strip(home)
        border = options.window_px // 2 + 1
        size = np.array([self._lens.width_px, self._lens.height_px])
        keep = (
            (np.abs(turned) < np.deg2rad(options.limb_deg))
            & (points[:, 1] >= first)
            & (points[:, 1] < last)
            & ((refined > border) & (refined < size - border)).all(axis=1)
        )
        chosen = np.flatnonzero(keep)[: options.points_per_frame * self._share(home)]
        return refined[chosen], points[chosen]

    def _strip(self, home: int) -> tuple[float, float]:
        """The stretch of cable, metres, that frame ``home`` gives points to; open at the two ends."""
        along = self._poses.centres[:, 1]
        first = -np.inf if home == 0 else (along[home - 1] + along[home]) / 2
        last = np.inf if home == len(along) - 1 else (along[home] + along[home + 1]) / 2
        return first, last

    def _share(self, home: int) -> int:
        """The end frames look further along the cable than the others: let them give more points."""
        return 4 if home in (0, len(self._poses) - 1) else 1

    def _follow(
        self, home: int, step: int, pixels: Array, starts: Array
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Array]]:
        alive, drift = np.arange(len(starts)), np.zeros_like(pixels)
        frame = home + step
        while 0 <= frame < len(self._poses) and len(alive):
            predicted = image_points(self._lens, *self._pose(frame), starts[alive]) + drift[alive]
            inside = self._inside(predicted)
            alive, predicted = alive[inside], predicted[inside]
            if not len(alive):
                return
            measured, good = self._find(home, frame, pixels[alive], predicted)
            drift[alive[good]] += (measured - predicted)[good]
            yield np.full(good.sum(), frame), alive[good], measured[good]
            alive = alive[good]
            frame += step

    def _find(
        self, home: int, frame: int, pixels: Array, predicted: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        options = self._options
        there, found, difference = self._flow(home, frame, pixels, predicted)
        back, returned, _ = self._flow(frame, home, there, pixels)
        good = found & returned & self._inside(there) & (difference < options.difference)
        return there, good & (np.linalg.norm(back - pixels, axis=1) < options.round_trip_px)

    def _flow(
        self, source: int, target: int, pixels: Array, guess: Array
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        """Pyramidal Lucas-Kanade; half a pixel between our origin and OpenCV's at both ends."""
        window = (self._options.window_px, self._options.window_px)
        moved, found, difference = cv2.calcOpticalFlowPyrLK(
            self._frames[source],
            self._frames[target],
            np.ascontiguousarray(pixels[:, None] - 0.5, dtype=np.float32),
            np.ascontiguousarray(guess[:, None] - 0.5, dtype=np.float32),
            winSize=window,
            maxLevel=PYRAMID_LEVELS,
            criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 0.005),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return moved[:, 0].astype(np.float64) + 0.5, found[:, 0] == 1, difference[:, 0].astype(np.float64)

    def _inside(self, pixels: Array) -> NDArray[np.bool_]:
        border = self._options.window_px // 2 + 1
        size = np.array([self._lens.width_px, self._lens.height_px])
        with np.errstate(invalid="ignore"):
            return ((pixels > border) & (pixels < size - border)).all(axis=1)

    def _pose(self, frame: int) -> tuple[Array, Array]:
        return self._poses.rotations[frame], self._poses.translations[frame]
