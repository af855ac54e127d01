"""All tiles as one cloud, evenly thinned: what photos are brought together with.

Takes the tiles; gives a :class:`~pipeline.steel.fuse_records.ScanCloud` of bounded size.
"""

import numpy as np

from pipeline.core.events import Emit, Event
from pipeline.steel.fuse_records import ScanCloud
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.tile_records import SitePoints, Tiles

MOST_POINTS = 4_000_000


def scan_cloud(tiles: Tiles, emit: Emit, most_points: int = MOST_POINTS) -> ScanCloud:
    """At most about ``most_points`` points of the tiles, the same share of each."""
    every = max(int(np.ceil(tiles.counts.sum() / most_points)), 1)
    reader = TileReader(tiles, most_points=1)
    parts = []
    for number, cell in enumerate(tiles.cells):
        emit(Event(stage="fuse", done=number, total=len(tiles.cells)))
        points = reader.tile(tuple(cell.tolist()))
        parts.append(points.where(np.arange(0, len(points), every)))
    points = SitePoints.joined(parts)
    return ScanCloud(
        points=points.places,
        stations=points.stations,
        scanners=np.array([pose.translation for pose in tiles.stations]),
        intensities=np.zeros(0),
    )
