"""The segments' surfaces laid end to end: one surface of the whole cable, no larger than memory allows.

Takes the segments' :class:`~pipeline.cable.ring.Ring` one after the other, and where each lies; gives one
Ring, in cells and texels as fine as theirs where the cable is short, else just fine enough that the whole
stays within a bound.  Over the frames that neighbours share the one fades into the other.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.ring import Alignment, Ring
from pipeline.core.vocabulary import Array

MOST_CELLS = 1_500_000
MOST_TEXELS = 30_000_000
ROWS = 512


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a segment's surface goes.

    Attributes:
        start_m: place of its origin along the cable.
        roll: its azimuths plus this are the whole's, radians.
        fade_in_m, fade_out_m: the ranges shared with the neighbours, places along the cable; None at an end.
    """

    start_m: float
    roll: float
    fade_in_m: tuple[float, float] | None
    fade_out_m: tuple[float, float] | None

    def share(self, y_m: Array) -> Array:
        """How much of the whole comes from this segment at places (n,), 0 to 1."""
        share = np.ones_like(y_m)
        if self.fade_in_m is not None:
            share = np.minimum(share, np.interp(y_m, self.fade_in_m, (0.0, 1.0)))
        if self.fade_out_m is not None:
            share = np.minimum(share, np.interp(y_m, self.fade_out_m, (1.0, 0.0)))
        return share


def join_rings(rings: Iterable[Ring], places: Sequence[Place], length_m: float) -> Ring:
    """Lay the segments' surfaces end to end.

    Args:
        rings: in the order of the cable; taken one after the other, so that they need not all be in memory.
        places: one each.
        length_m: of the cable, the first frame at 0.
    """
    whole: _Whole | None = None
    for ring, place in zip(rings, places, strict=True):
        if whole is None:
            whole = _Whole(ring, length_m)
        whole.add(ring, place)
    if whole is None:
        raise ValueError("there are no segments")
    return whole.ring()


class _Whole:
    """The surface so far: sums of what the segments say and of their shares."""

    def __init__(self, first: Ring, length_m: float) -> None:
        ends_m = -float(first.y_m[0])
        around_m = 2 * np.pi * float(np.nanmedian(first.radius_m))
        area_m2 = around_m * (length_m + 2 * ends_m)
        cell_m = max(float(first.y_m[1] - first.y_m[0]), float(np.sqrt(area_m2 / MOST_CELLS)))
        texel_m = max(first.texel_mm / 1000, float(np.sqrt(area_m2 / MOST_TEXELS)))
        self._azimuth, self._y_m = _grid(around_m, length_m, ends_m, cell_m)
        self._picture_azimuth, self._picture_y_m = _grid(around_m, length_m, ends_m, texel_m)
        self._texel_mm = 1000 * texel_m
        shape = (len(self._y_m), len(self._azimuth))
        picture = (len(self._picture_y_m), len(self._picture_azimuth))
        self._radius, self._weight = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
        self._measured = np.zeros(shape, bool)
        self._colour = np.zeros((*picture, 3), np.float32)
        self._known = np.zeros(picture, np.float32)

    def add(self, ring: Ring, place: Place) -> None:
        rows, share = _rows(self._y_m, ring.y_m, place)
        known = np.isfinite(ring.radius_m)
        maps = _Resampled(ring.azimuth, ring.y_m, self._azimuth, self._y_m[rows], place)
        weight = maps.of(known.astype(np.float32))
        radius = maps.of(np.where(known, ring.radius_m, 0).astype(np.float32))
        # a cell of which less than half is known would be a guess
        part = np.where(weight > 0.5, share[:, None], 0).astype(np.float32)
        self._radius[rows] += part * radius / np.maximum(weight, 1e-6)
        self._weight[rows] += part
        self._measured[rows] |= (maps.of(ring.measured.astype(np.float32)) > 0.5) & (part > 0)
        rows, share = _rows(self._picture_y_m, ring.picture_y_m, place)
        maps = _Resampled(
            ring.picture_azimuth, ring.picture_y_m, self._picture_azimuth, self._picture_y_m[rows], place
        )
        weight = share[:, None].astype(np.float32) * maps.of(ring.picture_known.astype(np.float32))
        self._colour[rows] += weight[..., None] * maps.of(ring.picture.astype(np.float32))
        self._known[rows] += weight

    def ring(self) -> Ring:
        known = self._weight > 0
        return Ring(
            alignment=Alignment(rotation=np.eye(3), translation=np.zeros(3)),
            azimuth=self._azimuth,
            y_m=self._y_m,
            radius_m=np.where(known, self._radius / np.where(known, self._weight, 1), np.nan),
            measured=self._measured,
            picture=self._picture(),
            picture_known=self._known > 1e-3,
            picture_y_m=self._picture_y_m,
            picture_azimuth=self._picture_azimuth,
            texel_mm=self._texel_mm,
        )

    def _picture(self) -> NDArray[np.uint8]:
        picture = np.empty(self._colour.shape, np.uint8)
        for first in range(0, len(picture), ROWS):  # or the steps in between would be whole pictures as well
            rows = slice(first, first + ROWS)
            mean = self._colour[rows] / np.maximum(self._known[rows], 1e-6)[..., None]
            picture[rows] = np.rint(np.clip(mean, 0, 255))
        return picture


class _Resampled:
    """Maps of a segment, rows along the cable and columns once around, at the cells of the whole."""

    def __init__(self, azimuth: Array, y_m: Array, to_azimuth: Array, to_y_m: Array, place: Place) -> None:
        turn, rise = azimuth[1] - azimuth[0], y_m[1] - y_m[0]
        # one column more than a cell of the whole covers, on both sides: there the map closes
        self._pad = int(np.ceil((to_azimuth[1] - to_azimuth[0]) / turn)) + 2
        column = (to_azimuth - place.roll - azimuth[0]) / turn % len(azimuth) + self._pad
        row = (to_y_m - place.start_m - y_m[0]) / rise
        grid = np.meshgrid(column.astype(np.float32), row.astype(np.float32))
        self._column, self._row = grid
        self._blur = (
            max((to_azimuth[1] - to_azimuth[0]) / turn, 1.0),
            max((to_y_m[1] - to_y_m[0]) / rise, 1.0) if len(to_y_m) > 1 else 1.0,
        )

    def of(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values (n, m) or (n, m, 3) averaged over about a cell of the whole."""
        wide = np.concatenate([values[:, -self._pad :], values, values[:, : self._pad]], axis=1)
        if max(self._blur) > 1.5:
            across, along = (max(s / 2.5, 1e-3) for s in self._blur)
            wide = cv2.GaussianBlur(wide, (0, 0), across, sigmaY=along, borderType=cv2.BORDER_REPLICATE)
        found = cv2.remap(wide, self._column, self._row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, dtype=np.float32)


def _grid(around_m: float, length_m: float, ends_m: float, cell_m: float) -> tuple[Array, Array]:
    """Azimuths around and places along the cable of cells of about this size."""
    columns = max(round(around_m / cell_m), 8)
    rows = max(round((length_m + 2 * ends_m) / cell_m), 2)
    azimuth = -np.pi + (np.arange(columns) + 0.5) * 2 * np.pi / columns
    return azimuth, -ends_m + (np.arange(rows) + 0.5) * (length_m + 2 * ends_m) / rows


def _rows(y_m: Array, segment_y_m: Array, place: Place) -> tuple[slice, Array]:
    """The rows of the whole that a segment reaches, and its share in each."""
    reach = segment_y_m[1] - segment_y_m[0]
    first = np.searchsorted(y_m, segment_y_m[0] + place.start_m - reach)
    end = np.searchsorted(y_m, segment_y_m[-1] + place.start_m + reach)
    rows = slice(int(first), int(end))
    return rows, place.share(y_m[rows])
