"""Stage *texture*: the unrolled picture of one block, from the frames (paper, section 2.4).

Takes original frames, the adjusted block and its surface; gives a colour for every texel of the unrolled
surface. A texel is looked up in the two frames that stand nearest, blended by their distance.  The exposure
is evened: what stays at the same place of every frame while the cable glides past is lamp and lens, and is
divided out.
"""

from collections import OrderedDict
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust import Orientation
from pipeline.cable.surface import BlockSurface
from pipeline.cable.surface_view import Image, SurfaceView, SweepGrid, sample
from pipeline.core.events import Emit, Event
from pipeline.core.pictures import Picture, read_colour
from pipeline.core.vocabulary import Array, FrameSequence

HELD_BYTES = 64 * 2**20
"""Decoded frames of one block that stay in memory while it is looked through twice."""


@dataclass(frozen=True, kw_only=True)
class TextureOptions:
    """How the unrolled picture is made.

    Attributes:
        texel_mm: side of a texel; 0 takes three quarters of the ground sample distance.
        even_exposure: divide out what lamp and lens add.
    """

    texel_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    even_exposure: bool = True


@dataclass(frozen=True, kw_only=True)
class UnrolledPicture:
    """The unrolled surface in colour.

    Attributes:
        azimuth: (m,) radians, columns.
        y_m: (n,) metres, rows.
        colour: (n, m, 3) uint8, blue, green, red.
        known: (n, m) bool.
        texel_mm: side of a texel along the cable.
    """

    azimuth: Array
    y_m: Array
    colour: NDArray[np.uint8]
    known: NDArray[np.bool_]
    texel_mm: float


def texture_block(
    frames: FrameSequence,
    orientation: Orientation,
    surface: BlockSurface,
    ground_mm: float,
    options: TextureOptions,
    emit: Emit,
) -> UnrolledPicture:
    """Make the unrolled picture of one block."""
    texel_mm = options.texel_mm or 0.75 * ground_mm
    grid, radius = _texels(surface, texel_mm)
    along = orientation.poses.centres[:, 1]
    before, share = _nearest_two(along, grid.y_m)
    reader = _ColourReader(frames)
    total = np.zeros((*radius.shape, 3), dtype=np.float32)
    weight = np.zeros(radius.shape, dtype=np.float32)
    pattern = _Pattern(orientation, grid, radius, reader) if options.even_exposure else None
    for frame in range(len(along)):
        emit(Event(stage="texture", block=frames.block, done=frame, total=len(along)))
        blend = np.where(before == frame, 1 - share, np.where(before + 1 == frame, share, 0))
        if not (blend > 0).any():
            continue
        rows = np.flatnonzero(blend > 0)
        strip = slice(int(rows[0]), int(rows[-1]) + 1)
        view = SurfaceView(orientation.lens, orientation.poses, frame, _rows(grid, strip))
        pixels = view.pixels(radius[strip])
        colour = sample(reader[frame], pixels)
        if pattern is not None:
            colour = colour / pattern.at(grid.y_m[strip] - along[frame])[..., None]
        factor = (view.visible(pixels, 1) * blend[strip, None]).astype(np.float32)
        total[strip] += np.nan_to_num(colour) * factor[..., None]
        weight[strip] += factor
    known = (weight > 0.3) & np.isfinite(radius)
    colour = total / np.maximum(weight, 1e-6)[..., None]
    return UnrolledPicture(
        azimuth=grid.azimuth,
        y_m=grid.y_m,
        colour=np.rint(np.where(known[..., None], np.clip(colour, 0, 255), 0)).astype(np.uint8),
        known=known,
        texel_mm=texel_mm,
    )


class _ColourReader:
    """Colour frames as float32; those of a short block are read once, of a long one the latest stay."""

    def __init__(self, frames: FrameSequence) -> None:
        self._frames = frames
        self._keep = max(HELD_BYTES // (3 * frames.width_px * frames.height_px), 4)
        self._held: OrderedDict[int, Picture] = OrderedDict()

    def __getitem__(self, frame: int) -> Image:
        if frame not in self._held:
            self._held[frame] = read_colour(self._frames.files[frame], "texture")
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        return self._held[frame].astype(np.float32)


class _Pattern:
    """What lamp and lens make of an even surface: brightness by azimuth and by place ahead of the camera.

    The cable glides through, so over many frames its own marks average out and the pattern stays.
    """

    SAMPLES = 15

    def __init__(
        self, orientation: Orientation, grid: SweepGrid, radius: Image, reader: _ColourReader
    ) -> None:
        along = orientation.poses.centres[:, 1]
        reach = 1.2 * float(np.max(np.diff(np.sort(along))))
        self._ahead = np.linspace(-reach, reach, self.SAMPLES)
        middle = np.float32(np.nanmedian(radius))
        logs = np.zeros((self.SAMPLES, len(grid.azimuth)))
        count = np.zeros_like(logs)
        for frame, y_m in enumerate(along):
            places = SweepGrid(axis=grid.axis, azimuth=grid.azimuth, y_m=y_m + self._ahead)
            view = SurfaceView(orientation.lens, orientation.poses, frame, places)
            even = np.full(logs.shape, middle, dtype=np.float32)
            pixels = view.pixels(even)
            seen = view.visible(pixels, 1) > 0
            gray = sample(reader[frame], pixels).mean(axis=2)
            logs += np.where(seen, np.log(np.maximum(gray, 1)), 0)
            count += seen
        mean = np.where(count > 0, logs / np.maximum(count, 1), 0)
        known = (count > 0).astype(np.float32)
        smooth = _blur(mean * known) / np.maximum(_blur(known), 1e-6)
        level = float(np.average(smooth, weights=known + 1e-9))
        self._pattern = np.exp(smooth - level)

    def at(self, ahead_m: Array) -> Image:
        """Brightness relative to the average, (n, m), for rows ``ahead_m`` (n,) ahead of the camera."""
        place = np.interp(ahead_m, self._ahead, np.arange(self.SAMPLES))
        low = np.minimum(place.astype(int), self.SAMPLES - 2)
        part = (place - low)[:, None]
        return self._pattern[low] * (1 - part) + self._pattern[low + 1] * part


def _blur(values: Image) -> Image:
    """Wide around the cable, for lamps change slowly; narrow along, where there are few samples."""
    wide = values.shape[1] / 25
    return np.asarray(cv2.GaussianBlur(values.astype(np.float32), (0, 0), sigmaX=wide, sigmaY=2.0))


def _texels(surface: BlockSurface, texel_mm: float) -> tuple[SweepGrid, Image]:
    """The picture's grid, and the surface's radius at each texel (NaN in holes)."""
    radius_m = float(np.nanmedian(surface.radius_m))
    along = np.arange(surface.y_m[0], surface.y_m[-1], texel_mm / 1000)
    around = np.arange(surface.azimuth[0], surface.azimuth[-1], texel_mm / 1000 / radius_m)
    column = np.interp(around, surface.azimuth, np.arange(len(surface.azimuth))).astype(np.float32)
    row = np.interp(along, surface.y_m, np.arange(len(surface.y_m))).astype(np.float32)
    where = np.meshgrid(column, row)
    radius = cv2.remap(surface.radius_m.astype(np.float32), where[0], where[1], cv2.INTER_LINEAR)
    return SweepGrid(axis=surface.axis, azimuth=around, y_m=along), np.asarray(radius)


def _rows(grid: SweepGrid, rows: slice) -> SweepGrid:
    return SweepGrid(axis=grid.axis, azimuth=grid.azimuth, y_m=grid.y_m[rows])


def _nearest_two(along: Array, y_m: Array) -> tuple[NDArray[np.int64], Array]:
    """For each row the frame before it and the share of the frame after it, 0 to 1."""
    before = np.clip(np.searchsorted(along, y_m) - 1, 0, len(along) - 2)
    share = np.clip((y_m - along[before]) / (along[before + 1] - along[before]), 0, 1)
    return before, share
