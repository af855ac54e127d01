"""Scans read with their intensities, whatever the format, and cut down to the cable."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.scan.reading import read_scan
from pipeline.scan.tube import find_cable
from pipeline.steel.cloud_readers import open_cloud
from pipeline.steel.survey_records import LengthUnit
from synth.scan.clouds import write_cloud
from synth.scan.spec import CloudFormat, Unit
from tests.scan.scanned_cable import RADIUS, placement, scanned, smooth


@pytest.mark.parametrize("kind", list(CloudFormat))
def test_intensities_come_along_with_every_format(kind, tmp_path):
    rng = np.random.default_rng(4)
    points, bright = rng.uniform(-2, 2, (500, 3)), rng.uniform(0.1, 0.9, 500)
    path = tmp_path / f"cloud.{kind}"
    write_cloud(path, points, bright, kind, Unit.METRE)
    with open_cloud(path, "cloud", bright=True) as cloud:
        read = np.concatenate(list(cloud.runs))
    assert read[:, :3] == pytest.approx(points, abs=1e-4)
    assert np.corrcoef(read[:, 3], bright)[0, 1] > 0.9999
    with open_cloud(path, "cloud") as cloud:
        assert np.concatenate(list(cloud.runs)).shape == (500, 3)


def test_a_file_without_intensities_says_nothing_of_them(tmp_path):
    path = tmp_path / "cloud.xyz"
    np.savetxt(path, np.random.default_rng(1).uniform(size=(20, 3)))
    with open_cloud(path, "cloud", bright=True) as cloud:
        assert np.isnan(np.concatenate(list(cloud.runs))[:, 3]).all()


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_the_cable_is_found_among_a_floor_a_wall_and_a_thicker_pipe(seed):
    points = scanned(smooth, seed)
    found = find_cable(points, 1.02 * RADIUS, lambda done: None)
    rotation, move = placement(seed)
    assert abs(found.direction @ rotation[:, 1]) > 0.999999
    away = found.place - move
    assert np.linalg.norm(away - (away @ found.direction) * found.direction) < 0.0005
    assert found.radius_m == pytest.approx(RADIUS, abs=2e-4)
    assert found.last_m - found.first_m == pytest.approx(0.75, abs=0.05)


def test_several_files_are_one_scan_and_each_point_knows_its_own(tmp_path):
    points = scanned(smooth, 24, room=False)
    for number, part in enumerate((points[:40_000], points[40_000:])):
        np.savetxt(tmp_path / f"{number}.xyz", part, fmt="%.5f")
    paths = (tmp_path / "0.xyz", tmp_path / "1.xyz")
    scan = read_scan(paths, LengthUnit.METRE, RADIUS, silent)
    assert np.bincount(scan.stations).tolist() == [40_000, 30_000]
    assert len(scan.intensities) == 0


def test_a_room_without_a_cable_is_refused(tmp_path):
    points = scanned(smooth, 25)[70_000:]  # floor, wall and pipe
    np.savetxt(tmp_path / "room.xyz", points, fmt="%.5f")
    with pytest.raises(StageError, match="no cable of about 110 mm diameter is in room"):
        read_scan((tmp_path / "room.xyz",), LengthUnit.METRE, RADIUS, silent)
