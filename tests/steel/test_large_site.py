"""Memory of the tiles grows neither with the number of stations nor with their points.

Small here; the paper's size by hand: ``python -m tests.steel.large_site`` (tiles) and ``large_survey`` (all).
"""

import json
import subprocess
import sys

from tests.command import ROOT

CHUNK_MB = 500
"""Two million points at once, in double precision, with what sorting them takes."""


def peak_mb(stations, points):
    asked = ["--stations", str(stations), "--points", str(points), "--clouds", "1", "--tiles-searched", "0"]
    done = subprocess.run(
        [sys.executable, "-m", "tests.steel.large_site", *asked],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    told = json.loads(done.stdout)
    assert told["points"] == stations * points
    assert told["kept"] > 0.5 * told["points"]
    return told["after_tiles"]["peak_mb"]


def test_five_times_the_stations_need_no_more_memory():
    few, many = peak_mb(2, 200_000), peak_mb(10, 200_000)
    assert many < few + 30


def test_points_of_a_station_are_taken_in_chunks():
    two, four = peak_mb(1, 4_000_000), peak_mb(1, 8_000_000)
    # mapped files count as memory while they are read: four million points are 48 MB
    assert four < two + 48 + 30
    assert four < CHUNK_MB + 100
