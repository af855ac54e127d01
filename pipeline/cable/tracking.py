"""Tracking of surface points through a block's frames, each from the frame that sees it best.

Takes original frames, their lens, predicted orientations and the cable's rough radius; gives image points,
sub-pixel, in the original frames.  Every frame is first laid onto the predicted cylinder (a *sheet*: azimuth
by place along the cable), where one piece of surface looks alike in all frames, near the limb too: in the
frame itself the depth varies so much across a template there that the frames shear against each other by
pixels.  A template is cut once, where the camera stands nearest to the point, and found again on every other
sheet, so no error adds up along the track.  The way back from sheet to frame undoes the way there: the
cylinder need not be the true surface.  Lighting travels with the robot; normalising to local mean and
contrast takes it out.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface_view import SurfaceView, SweepGrid, sample
from pipeline.core.axis import AxisCurve
from pipeline.core.division import project
from pipeline.core.vocabulary import Array, Lens, Poses

Gray = NDArray[np.uint8]
PYRAMID_LEVELS = 2
NEAR = 0.4
"""Where the last frame's points were found within so many windows of their guess, one level will do."""
END_SHARE = 4  # the end frames look further along the cable than the others: let them give more points


@dataclass(frozen=True, kw_only=True)
class TrackOptions:
    """How points are chosen and followed.

    Attributes:
        points_per_frame: new points in each frame, spread over its own strip of surface.
        limb_deg: points further than this from the camera's azimuth are left out.
        window_px: side of the template, in texels of about a pixel's size on the surface.
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
        pixels: (k, 2) in the original frames.
    """

    home: int
    starts: Array
    frame: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array


def normalise(image: NDArray[np.uint8] | NDArray[np.float32], radius_px: float) -> Gray:
    """Take out local mean and contrast: 128 + 40 standard deviations, (h, w) uint8."""
    values = image.astype(np.float32)
    mean = cv2.GaussianBlur(values, (0, 0), radius_px)
    spread = cv2.GaussianBlur((values - mean) ** 2, (0, 0), radius_px)
    scaled = 128 + 40 * (values - mean) / np.sqrt(spread + 4.0)
    return np.rint(np.clip(scaled, 0, 255)).astype(np.uint8)


@dataclass(frozen=True)
class _Sheet:
    """One frame laid onto the cylinder: (h, w) picture, the grid's row of its first row."""

    picture: Gray
    first_row: int


class Tracker:
    """Follows the surface of one block.

    Places are (column, row) on the grid that all sheets share: columns turn around the cable by one texel,
    rows rise along it, row 0 at y = 0.

    Args:
        read: gives the grey original frame k, (h, w) uint8.
        lens: of the original frames.
        poses: predicted orientations.
        azimuth_deg: of the block's camera.
        cylinder: axis and rough radius (m) of the cable.
        keep: so many sheets stay in memory.
    """

    def __init__(
        self,
        read: Callable[[int], Gray],
        lens: Lens,
        poses: Poses,
        azimuth_deg: float,
        cylinder: tuple[AxisCurve, float],
        options: TrackOptions,
        keep: int = 64,
    ) -> None:
        self._read, self._lens, self._poses, self._options = read, lens, poses, options
        self._axis, self._radius_m = cylinder
        self._along = poses.centres[:, 1]
        away = poses.centres - self._axis.at(self._along)
        depth_m = float(np.median(np.hypot(away[:, 0], away[:, 2]))) - self._radius_m
        self._texel_m = depth_m / lens.focal_px
        limb = np.deg2rad(options.limb_deg) + options.window_px / 2 * self._texel_m / self._radius_m
        self._azimuth = np.deg2rad(azimuth_deg) + np.arange(-limb, limb, self._texel_m / self._radius_m)
        self._reach = int(0.6 * max(lens.width_px, lens.height_px))
        self._keep = keep
        self._held: OrderedDict[int, _Sheet] = OrderedDict()

    def track(self, home: int) -> Track:
        """Choose points on the sheet of frame ``home`` and follow them both ways until they leave the
        view."""
        return self.follow(home, self._choose(home))

    def follow(self, home: int, places: Array) -> Track:
        """Follow points at places (m, 2) of frame ``home`` both ways."""
        everything = np.arange(len(places))
        found = [(np.full(len(places), home), everything, places)]
        for step in (1, -1):
            found.extend(self._follow(home, step, places))
        frame, point, where = (np.concatenate(part) for part in zip(*found, strict=True))
        pixels = np.empty((len(frame), 2))
        for k in np.unique(frame):
            mine = frame == k
            pixels[mine] = self._pixels(int(k), where[mine])
        seen = self._in_frame(pixels)
        return Track(
            home=home,
            starts=self.surface(places),
            frame=frame[seen],
            point=point[seen],
            pixels=pixels[seen],
        )

    def surface(self, places: Array) -> Array:
        """Points of the cylinder at places (m, 2), (m, 3) metres."""
        azimuth = self._azimuth[0] + places[:, 0] * (self._azimuth[1] - self._azimuth[0])
        y_m = places[:, 1] * self._texel_m
        return self._axis.roll(azimuth, y_m, np.full(len(places), self._radius_m))

    def places(self, azimuth: Array, y_m: Array) -> Array:
        """Places (m, 2) of azimuths (m,) in radians and y (m,) in metres."""
        middle = self._azimuth.mean()
        turned = middle + np.angle(np.exp(1j * (azimuth - middle)))
        column = (turned - self._azimuth[0]) / (self._azimuth[1] - self._azimuth[0])
        return np.stack([column, y_m / self._texel_m], axis=1)

    def _sheet(self, frame: int) -> _Sheet:
        if frame not in self._held:
            middle = round(self._along[frame] / self._texel_m)
            first = middle - self._reach
            y_m = (first + np.arange(2 * self._reach + 1)) * self._texel_m
            grid = SweepGrid(axis=self._axis, azimuth=self._azimuth, y_m=y_m)
            view = SurfaceView(self._lens, self._poses, frame, grid)
            radius = np.full((len(y_m), len(self._azimuth)), self._radius_m, dtype=np.float32)
            # OpenCV's cubic moves edges by up to 0.05 px, depending on where between the pixels they lie
            pixels = view.pixels(radius)
            picture = sample(self._read(frame).astype(np.float32), pixels, cv2.INTER_LANCZOS4)
            seen = view.visible(pixels, 1) > 0
            filled = np.where(seen, picture, picture[seen].mean() if seen.any() else 0)
            normal = normalise(filled.astype(np.float32), self._options.normalise_px)
            self._held[frame] = _Sheet(normal, first)  # all of one size: OpenCV's tracker demands it
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        self._held.move_to_end(frame)
        return self._held[frame]

    def _choose(self, home: int) -> Array:
        """Corners on the stretch of surface that frame ``home`` sees best, as places (m, 2)."""
        options, sheet = self._options, self._sheet(home)
        first, last = self._stretch(home)
        mask = np.zeros_like(sheet.picture)
        low = 0 if first is None else max(first - sheet.first_row, 0)
        high = len(mask) if last is None else max(last - sheet.first_row, 0)
        margin = options.window_px // 2 + 1
        mask[max(low, margin) : min(high, len(mask) - margin), margin:-margin] = 255
        most = options.points_per_frame * (END_SHARE if first is None or last is None else 1)
        found = cv2.goodFeaturesToTrack(sheet.picture, most, 0.01, minDistance=3, mask=mask, blockSize=7)
        if found is None:
            return np.zeros((0, 2))
        places = found[:, 0].astype(np.float64) + np.array([0, sheet.first_row])
        return places[self._in_frame(self._pixels(home, places))]

    def _stretch(self, home: int) -> tuple[int | None, int | None]:
        """First and last row that frame ``home`` gives points to; None where it is open at an end."""
        along = self._along
        first = None if home == 0 else round((along[home - 1] + along[home]) / 2 / self._texel_m)
        last = None
        if home < len(along) - 1:
            last = round((along[home] + along[home + 1]) / 2 / self._texel_m)
        return first, last

    def _follow(
        self, home: int, step: int, places: Array
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Array]]:
        alive, drift = np.arange(len(places)), np.zeros_like(places)
        frame, levels = home + step, PYRAMID_LEVELS
        while 0 <= frame < len(self._poses) and len(alive):
            guess = places[alive] + drift[alive]
            inside = self._on_sheet(frame, guess)
            alive, guess = alive[inside], guess[inside]
            if not len(alive):
                return
            measured, good = self._find(home, frame, places[alive], guess, levels)
            alive, measured = alive[good], measured[good]
            drift[alive] = measured - places[alive]
            missed = np.linalg.norm(measured - guess[good], axis=1)
            near = len(missed) and np.percentile(missed, 90) < NEAR * self._options.window_px
            levels = 1 if near else PYRAMID_LEVELS
            yield np.full(len(alive), frame), alive, measured
            frame += step

    def _find(
        self, home: int, frame: int, places: Array, guess: Array, levels: int
    ) -> tuple[Array, NDArray[np.bool_]]:
        options = self._options
        there, found, difference = self._flow(home, frame, places, guess, levels)
        # begun at its known end: it leaves it where it was wrong, and needs no pyramid
        back, returned, _ = self._flow(frame, home, there, places, 0)
        good = found & returned & self._on_sheet(frame, there) & (difference < options.difference)
        return there, good & (np.linalg.norm(back - places, axis=1) < options.round_trip_px)

    def _flow(
        self, source: int, target: int, places: Array, guess: Array, levels: int
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        """Pyramidal Lucas-Kanade from sheet to sheet, on no more of them than the points need."""
        one, other = self._sheet(source), self._sheet(target)
        rows = places[:, 1] - one.first_row, guess[:, 1] - other.first_row
        first, second = self._strips(*rows, self._options.window_px << levels)
        window = (self._options.window_px, self._options.window_px)
        moved, found, difference = cv2.calcOpticalFlowPyrLK(
            one.picture[first],
            other.picture[second],
            np.ascontiguousarray((places - [0, one.first_row + first.start])[:, None], dtype=np.float32),
            np.ascontiguousarray((guess - [0, other.first_row + second.start])[:, None], dtype=np.float32),
            winSize=window,
            maxLevel=levels,
            criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 0.005),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        there = moved[:, 0].astype(np.float64) + np.array([0, other.first_row + second.start])
        lost = found[:, 0] != 1  # OpenCV leaves whatever stood there
        return there, ~lost, np.where(lost, np.inf, np.nan_to_num(difference[:, 0], nan=np.inf))

    def _strips(self, rows: Array, guessed_rows: Array, margin: int) -> tuple[slice, slice]:
        """Two strips of sheet, of one height, that hold the points with room for the coarsest template."""
        height = 2 * self._reach + 1
        lows = [int(r.min()) - margin for r in (rows, guessed_rows)]
        highs = [int(r.max()) + margin for r in (rows, guessed_rows)]
        size = min(max(high - low for low, high in zip(lows, highs, strict=True)), height)
        starts = [min(max(low, 0), height - size) for low in lows]
        return slice(starts[0], starts[0] + size), slice(starts[1], starts[1] + size)

    def _on_sheet(self, frame: int, places: Array) -> NDArray[np.bool_]:
        """Whether the whole template lies on the frame's sheet."""
        sheet, border = self._sheet(frame), self._options.window_px // 2 + 1
        row = places[:, 1] - sheet.first_row
        inside = (row > border) & (row < len(sheet.picture) - border)
        return inside & (places[:, 0] > border) & (places[:, 0] < len(self._azimuth) - border)

    def _pixels(self, frame: int, places: Array) -> Array:
        """Where the places were looked up in the original frame, (m, 2)."""
        rotation, translation = self._poses.rotations[frame], self._poses.translations[frame]
        return project(self._lens, self.surface(places) @ rotation.T + translation)

    def _in_frame(self, pixels: Array) -> NDArray[np.bool_]:
        border = self._options.window_px / 2
        size = np.array([self._lens.width_px, self._lens.height_px])
        with np.errstate(invalid="ignore"):
            return ((pixels > border) & (pixels < size - border)).all(axis=1)
