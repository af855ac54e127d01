"""Slices of the placed blocks: what a section is fitted to.

Takes blocks, crops and places; gives, for a place along the cable, the mean points of narrow bins around it.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.cable.crop import Crop
from pipeline.cable.mosaic import Mosaic, MosaicBlock
from pipeline.cable.ring import Ring
from pipeline.core.vocabulary import Array


@dataclass(frozen=True)
class Cut:
    """The binned points of all blocks in one slice: (k, 3) mm, weights, block of each, angle seen, length."""

    points: Array
    weights: Array
    block: Array
    coverage_deg: float
    length_mm: float


class Cutter:
    """Cuts slices out of the placed blocks."""

    def __init__(
        self,
        blocks: tuple[MosaicBlock, ...],
        crops: tuple[Crop, ...],
        mosaic: Mosaic,
        ring: Ring,
        bin_deg: float,
    ) -> None:
        self._blocks, self._crops, self._bin_deg = blocks, crops, bin_deg
        self._place = mosaic.placement
        self._align = ring.alignment

    def cut(self, y_m: float, length_mm: float) -> Cut:
        """Bin all blocks' measured cells within ``length_mm`` about ``y_m``."""
        parts = [self._cut_block(n, y_m, length_mm) for n in range(len(self._blocks))]
        points, weights = (np.concatenate([p[i] for p in parts]) for i in (0, 1))
        block = np.concatenate([np.full(len(p[0]), n) for n, p in enumerate(parts)])
        width_deg = np.concatenate([np.full(len(p[0]), p[2]) for p in parts])
        return Cut(points, weights, block, _coverage_deg(points, width_deg), length_mm)

    def _cut_block(self, number: int, y_m: float, length_mm: float) -> tuple[Array, Array, float]:
        """The filled bins' mean points, their weights, and the width of a bin in degrees."""
        block, crop = self._blocks[number], self._crops[number]
        half = length_mm / 2000
        near = np.abs(block.surface.y_m - y_m) < half + 0.005
        rows = slice(int(np.argmax(near)), int(len(near) - np.argmax(near[::-1]))) if near.any() else slice(0)
        points = self._align.apply(self._place.apply(number, block.surface.points(rows)))
        use = crop.keep[rows] & block.surface.measured[rows] & (np.abs(points[..., 1] - y_m) < half)
        cell_deg = float(np.rad2deg(block.surface.azimuth[1] - block.surface.azimuth[0]))
        per_bin = max(round(self._bin_deg / cell_deg), 1)
        columns = use.shape[1] // per_bin
        shape = (use.shape[0], columns, per_bin)
        use = use[:, : columns * per_bin].reshape(shape)
        count = use.sum(axis=(0, 2))
        points = np.where(use[..., None], points[:, : columns * per_bin].reshape(*shape, 3), 0)
        mean = points.sum(axis=(0, 2)) / np.maximum(count, 1)[:, None]
        incidence = crop.incidence_deg[: columns * per_bin].reshape(columns, per_bin).mean(axis=1)
        filled = count > 0.2 * use.shape[0] * per_bin
        weight = np.cos(np.deg2rad(incidence)) ** 2 * count / max(use.shape[0] * per_bin, 1)
        return 1000 * mean[filled], weight[filled], per_bin * cell_deg


def _coverage_deg(points: Array, width_deg: Array) -> float:
    """Angle around the axis that bins at points (k, 3) of widths (k,) cover, to half a degree."""
    middle = np.rad2deg(np.arctan2(-points[:, 2], points[:, 0]))
    parts = np.linspace(-0.5, 0.5, 2 + int(4 * width_deg.max(initial=0.0)))
    marks = middle[:, None] + width_deg[:, None] * parts
    return len(np.unique(np.floor(2 * marks) % 720)) / 2
