"""Reading tiles: the points of a tile with a margin, or along a piece of a line; few tiles held at once."""

from collections import OrderedDict
from itertools import pairwise, product
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.tile_records import RECORD, SitePoints, Tiles
from pipeline.steel.vectors import dots


class TileReader:
    """Reads points out of tiles and keeps the ones read last; several threads may read from one.

    Args:
        tiles: the index.
        most_points: points held in memory at once.
    """

    def __init__(self, tiles: Tiles, most_points: int = 20_000_000) -> None:
        self.tiles = tiles
        self._most_points = most_points
        self._present = {tuple(cell) for cell in tiles.cells.tolist()}
        self._held: OrderedDict[tuple[int, ...], SitePoints] = OrderedDict()
        self._one_at_a_time = Lock()

    def tile(self, cell: tuple[int, ...]) -> SitePoints:
        """All points of one tile; none where there is no such tile."""
        if cell not in self._present:
            return SitePoints.joined([])
        with self._one_at_a_time:
            if cell in self._held:
                self._held.move_to_end(cell)
                return self._held[cell]
            return self._read(cell)

    def _read(self, cell: tuple[int, ...]) -> SitePoints:
        records = np.fromfile(self.tiles.path(cell), dtype=RECORD)
        places = records["place"].astype(float) + np.array(cell) * self.tiles.tile_m
        points = SitePoints(places=places, stations=records["station"].astype(np.int64))
        while self._held and sum(map(len, self._held.values())) + len(points) > self._most_points:
            self._held.popitem(last=False)
        self._held[cell] = points
        return points

    def box(self, low: Array, high: Array) -> SitePoints:
        """The points between two corners (3,) of a box along the axes of the site."""
        parts = []
        for cell in self._cells(low, high):
            points = self.tile(cell)
            parts.append(points.where(_between(points.places, low, high)))
        return SitePoints.joined(parts)

    def capsule(self, start: Array, end: Array, radius: float) -> SitePoints:
        """The points within ``radius`` of the straight piece from ``start`` to ``end`` (3,)."""
        length = float(np.linalg.norm(end - start))
        # slanting pieces are read in short boxes: one long box would hold mostly other points
        steps = np.linspace(0, 1, max(int(np.ceil(length / 1.0)), 1) + 1)
        nodes = start + steps[:, None] * (end - start)
        axis = (end - start) / max(length, 1e-12)
        parts = []
        for number, (a, b) in enumerate(pairwise(nodes)):
            points = self.box(np.minimum(a, b) - radius, np.maximum(a, b) + radius)
            along = (points.places - start) @ axis
            apart = points.places - start - np.clip(along, 0, length)[:, None] * axis
            mine = dots(apart, apart) < radius**2
            # each point belongs to one box: the ends of the whole piece are open
            if number > 0:
                mine &= along >= steps[number] * length
            if number < len(nodes) - 2:
                mine &= along < steps[number + 1] * length
            parts.append(points.where(mine))
        return SitePoints.joined(parts)

    def _cells(self, low: Array, high: Array) -> list[tuple[int, ...]]:
        first = np.floor(low / self.tiles.tile_m).astype(int)
        last = np.floor(high / self.tiles.tile_m).astype(int)
        ranges = [range(a, b + 1) for a, b in zip(first.tolist(), last.tolist(), strict=True)]
        return [cell for cell in product(*ranges) if cell in self._present]


def _between(places: Array, low: Array, high: Array) -> NDArray[np.int64]:
    """Indices of the points in a box; coordinate by coordinate, because most are out after the first."""
    index = np.flatnonzero((places[:, 0] >= low[0]) & (places[:, 0] < high[0]))
    for k in (1, 2):
        value = places[index, k]
        index = index[(value >= low[k]) & (value < high[k])]
    return index
