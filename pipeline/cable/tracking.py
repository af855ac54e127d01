"""Tracking of surface points through a block's frames, each from the frame that sees it best.

Takes original frames, their lens, predicted orientations and the cable's rough radius; gives image points,
sub-pixel, in the original frames.  Every frame is first laid onto the predicted cylinder (``sheets``).  A
template is cut once, where the camera stands nearest to the point, and found again on every other sheet, so
no error adds up along the track.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.sheets import Filmed, Sheets
from pipeline.core.vocabulary import Array

NEAR = (0.1, 0.4)
"""Where nine of ten points were found within so many windows of their guess in the frame before, the pictures
as they are will do, or a pyramid of one level more; else it is of two."""
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


class Tracker:
    """Follows the surface of one block from sheet to sheet.

    Args:
        filmed: its frames.
        options: see there.
        keep: so many sheets stay in memory.
    """

    def __init__(self, filmed: Filmed, options: TrackOptions, keep: int = 64) -> None:
        self._size_px = np.array([filmed.lens.width_px, filmed.lens.height_px])
        self._options, self._border_px = options, options.window_px // 2 + 1
        self.sheets = Sheets(
            filmed,
            limb_deg=options.limb_deg,
            margin_px=options.window_px / 2,
            normalise_px=options.normalise_px,
            keep=keep,
        )

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
            pixels[mine] = self.sheets.pixels(int(k), where[mine])
        seen = self._in_frame(pixels)
        return Track(
            home=home,
            starts=self.sheets.surface(places),
            frame=frame[seen],
            point=point[seen],
            pixels=pixels[seen],
        )

    def _choose(self, home: int) -> Array:
        """Corners on the stretch of surface that frame ``home`` sees best, as places (m, 2)."""
        options, sheet = self._options, self.sheets[home]
        first, last = self._stretch(home)
        margin, height = options.window_px // 2 + 1, len(sheet.picture)
        low = margin if first is None else max(first - sheet.first_row, margin)
        high = height - margin if last is None else min(last - sheet.first_row, height - margin)
        if low >= high:
            return np.zeros((0, 2))
        rows = slice(low - margin, high + margin)  # with room for the outermost corners' own surroundings
        mask = np.zeros_like(sheet.picture[rows])
        mask[margin:-margin, margin:-margin] = 255
        most = options.points_per_frame * (END_SHARE if first is None or last is None else 1)
        found = cv2.goodFeaturesToTrack(
            sheet.picture[rows], most, 0.01, minDistance=3, mask=mask, blockSize=7
        )
        if found is None:
            return np.zeros((0, 2))
        places = found[:, 0].astype(np.float64) + np.array([0, sheet.first_row + rows.start])
        return places[self._in_frame(self.sheets.pixels(home, places))]

    def _stretch(self, home: int) -> tuple[int | None, int | None]:
        """First and last row that frame ``home`` gives points to; None where it is open at an end."""
        along = self.sheets.along_m
        first = None if home == 0 else round((along[home - 1] + along[home]) / 2 / self.sheets.texel_m)
        last = None
        if home < len(along) - 1:
            last = round((along[home] + along[home + 1]) / 2 / self.sheets.texel_m)
        return first, last

    def _follow(
        self, home: int, step: int, places: Array
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Array]]:
        alive, drift = np.arange(len(places)), np.zeros_like(places)
        frame, levels = home + step, len(NEAR)
        while 0 <= frame < len(self.sheets.along_m) and len(alive):
            guess = places[alive] + drift[alive]
            inside = self.sheets.hold(frame, guess, self._border_px)
            alive, guess = alive[inside], guess[inside]
            if not len(alive):
                return
            measured, good = self._find(home, frame, places[alive], guess, levels)
            alive, measured = alive[good], measured[good]
            drift[alive] = measured - places[alive]
            missed = np.linalg.norm(measured - guess[good], axis=1)
            near_px = np.array(NEAR) * self._options.window_px
            levels = int(np.count_nonzero((missed[:, None] < near_px).sum(axis=0) <= 0.9 * len(missed)))
            yield np.full(len(alive), frame), alive, measured
            frame += step

    def _find(
        self, home: int, frame: int, places: Array, guess: Array, levels: int
    ) -> tuple[Array, NDArray[np.bool_]]:
        options = self._options
        there, found, difference = self._flow(home, frame, places, guess, levels)
        # begun at its known end: it leaves it where it was wrong, and needs no pyramid
        back, returned, _ = self._flow(frame, home, there, places, 0)
        good = (
            found
            & returned
            & self.sheets.hold(frame, there, self._border_px)
            & (difference < options.difference)
        )
        return there, good & (np.linalg.norm(back - places, axis=1) < options.round_trip_px)

    def _flow(
        self, source: int, target: int, places: Array, guess: Array, levels: int
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        """Pyramidal Lucas-Kanade from sheet to sheet, on no more of them than the points need."""
        one, other = self.sheets[source], self.sheets[target]
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
        height = self.sheets.height
        lows = [int(r.min()) - margin for r in (rows, guessed_rows)]
        highs = [int(r.max()) + margin for r in (rows, guessed_rows)]
        size = min(max(high - low for low, high in zip(lows, highs, strict=True)), height)
        starts = [min(max(low, 0), height - size) for low in lows]
        return slice(starts[0], starts[0] + size), slice(starts[1], starts[1] + size)

    def _in_frame(self, pixels: Array) -> NDArray[np.bool_]:
        border = self._options.window_px / 2
        with np.errstate(invalid="ignore"):
            return ((pixels > border) & (pixels < self._size_px - border)).all(axis=1)
