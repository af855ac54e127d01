"""What the tiles of registered points are: options, index, and the points that come out of them."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.records import StationPose

RECORD = np.dtype([("place", "<f4", 3), ("station", "<u2")])
"""A point on disk: metres from its tile's lower corner, and the number of its station."""


@dataclass(frozen=True, kw_only=True)
class TileOptions:
    """How registered points are kept.

    Attributes:
        tile_m: edge of the cubes that the site is cut into.
        spacing_m: points of one station that lie closer than this, seen from it, are thinned.
        nearest_m: points closer to the scanner than this are its own tripod.
        farthest_m: points farther away are dropped.
        chunk_points: points worked on at once.
        most_points: points kept of one tile; more are thinned at random.
    """

    tile_m: float = field(default=4.0, metadata={"minimum": 1.0, "maximum": 100.0})
    spacing_m: float = field(default=0.004, metadata={"minimum": 0.0005, "maximum": 0.05})
    nearest_m: float = field(default=0.5, metadata={"minimum": 0.0})
    farthest_m: float = field(default=80.0, metadata={"above": 1.0})
    chunk_points: int = field(default=2_000_000, metadata={"minimum": 10_000})
    most_points: int = field(default=6_000_000, metadata={"minimum": 100_000})


@dataclass(frozen=True, kw_only=True)
class SitePoints:
    """Points of several stations.

    Attributes:
        places: (n, 3) metres, site frame.
        stations: (n,) number of each point's station.
    """

    places: Array
    stations: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.places)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> "SitePoints":
        """Some of the points."""
        return SitePoints(places=self.places[chosen], stations=self.stations[chosen])

    @staticmethod
    def joined(parts: list["SitePoints"]) -> "SitePoints":
        """All points of the parts, in their order."""
        return SitePoints(
            places=np.concatenate([np.zeros((0, 3)), *[p.places for p in parts]]),
            stations=np.concatenate([np.zeros(0, dtype=np.int64), *[p.stations for p in parts]]),
        )


@dataclass(frozen=True, kw_only=True)
class Tiles:
    """The registered points of all stations on disk, one file a tile.

    Attributes:
        folder: holds ``I_J_K.bin``, records of :data:`RECORD`.
        tile_m: edge of a tile.
        stations: where they stood; a point's station number counts in this order.
        cells: (m, 3) int64, numbers of the tiles that hold points: tile (i, j, k) begins at (i, j, k) tile_m.
        counts: (m,) int64, points in each.
        read_points: points that the stations' clouds held.
    """

    folder: Path
    tile_m: float
    stations: tuple[StationPose, ...]
    cells: NDArray[np.int64]
    counts: NDArray[np.int64]
    read_points: int

    def path(self, cell: tuple[int, ...]) -> Path:
        """Where the points of a tile lie."""
        return self.folder / ("_".join(str(int(n)) for n in cell) + ".bin")
