"""A grid of cells swept strip by strip, each strip against the frame that stands nearest.

Takes a block's frames and orientation, and for each pass the cells, where to begin and what to try; gives
what the sweep of every strip found, put together.  Memory: one strip and the frames that it sees.
"""

from collections import OrderedDict
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust import Orientation
from pipeline.cable.surface_view import SweepGrid
from pipeline.cable.sweep import FrameReader, StripFrames, SweepPass, SweepResult, sweep_strip
from pipeline.core.events import Emit, Event
from pipeline.core.pictures import read_grey
from pipeline.core.vocabulary import FrameSequence

KEPT_FRAMES = 40


class Strips:
    """Sweeps the grids of one block.

    Args:
        frames: original frames.
        orientation: the adjusted block.
        baselines_mm: distances to the frames compared with, on either side.
        passes: how many sweeps there will be.
        emit: progress, one event a strip.
    """

    def __init__(
        self,
        frames: FrameSequence,
        orientation: Orientation,
        baselines_mm: tuple[float, ...],
        passes: int,
        emit: Emit,
    ) -> None:
        self._frames, self._orientation, self._baselines_mm = frames, orientation, baselines_mm
        self._passes, self._emit, self._done = passes, emit, 0
        self._along = orientation.poses.centres[:, 1]
        self._grey: OrderedDict[int, NDArray[np.uint8]] = OrderedDict()
        self._readers: dict[tuple[float, float], FrameReader] = {}

    def sweep(self, wanted: SweepPass) -> SweepResult:
        """Sweep once."""
        grid, shape = wanted.grid, wanted.start_m.shape
        fields = ("radius_m", "score", "radius_ahead_m", "radius_behind_m")
        whole = {f: np.full(shape, np.nan, dtype=np.float32) for f in fields}
        reader = self._reader(wanted.blur_px, wanted.detail_px)
        nearest = np.abs(grid.y_m[:, None] - self._along).argmin(axis=1)
        halo = wanted.window // 2
        y_m = np.pad(grid.y_m, halo, mode="reflect", reflect_type="odd")
        start_m = np.pad(wanted.start_m, ((halo, halo), (0, 0)), mode="edge")
        for reference in range(len(self._along)):
            self._tell()
            rows = np.flatnonzero(nearest == reference)
            if not len(rows):
                continue
            strip = slice(rows[0], rows[-1] + 2 * halo + 1)
            seen = StripFrames(
                read=reader,
                lens=self._orientation.lens,
                poses=self._orientation.poses,
                reference=reference,
                ahead=self._neighbours(reference, 1),
                behind=self._neighbours(reference, -1),
            )
            cells = SweepGrid(axis=grid.axis, azimuth=grid.azimuth, y_m=y_m[strip])
            found = sweep_strip(seen, replace(wanted, grid=cells, start_m=start_m[strip]))
            for name, values in whole.items():
                values[rows] = getattr(found, name)[rows - rows[0] + halo]
        return SweepResult(**whole)

    def _reader(self, blur_px: float, detail_px: float) -> FrameReader:
        """Frames prepared so; those of the pass before, where it looked at them alike."""
        held = self._readers.get((blur_px, detail_px))
        reader = held or FrameReader(self._read, blur_px, detail_px, KEPT_FRAMES)
        self._readers = {(blur_px, detail_px): reader}
        return reader

    def _tell(self) -> None:
        total = self._passes * len(self._along)
        self._emit(Event(stage="dense", block=self._frames.block, done=self._done, total=total))
        self._done += 1

    def _neighbours(self, reference: int, side: int) -> tuple[int, ...]:
        """Frames about the wanted baselines away, on one side; much closer ones cannot tell the radius."""
        here = self._along[reference]
        least_m = 0.75 * min(self._baselines_mm) / 1000
        chosen = []
        for baseline_mm in self._baselines_mm:
            frame = int(np.abs(self._along - (here + side * baseline_mm / 1000)).argmin())
            if (self._along[frame] - here) * side > least_m and frame not in chosen:
                chosen.append(frame)
        return tuple(chosen)

    def _read(self, frame: int) -> NDArray[np.uint8]:
        """A grey frame; the latest stay in memory, for the next pass."""
        if frame not in self._grey:
            file = self._frames.files[frame]
            self._grey[frame] = read_grey(file, "dense")
            if len(self._grey) > KEPT_FRAMES:
                self._grey.popitem(last=False)
        self._grey.move_to_end(frame)
        return self._grey[frame]
