"""Any format of cloud becomes the same float32 array; what is wrong with a file is told in one sentence."""

import laspy
import numpy as np
import pye57
import pytest
from plyfile import PlyData, PlyElement

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel import cloud_readers
from pipeline.steel.clouds import import_cloud, station_points
from pipeline.steel.survey_records import LengthUnit, ScanStation


@pytest.fixture(scope="module")
def points():
    rng = np.random.default_rng(3)
    return rng.uniform(-1, 1, (2500, 3)) * [30, 20, 6] + [0, 0, 3]


def write_e57(path, points):
    file = pye57.E57(str(path), mode="w")
    file.write_scan_raw({f"cartesian{axis}": points[:, k] for k, axis in enumerate("XYZ")})
    file.close()


def write_las(path, points):
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = [1e-4] * 3
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.write(str(path))


def write_ply(path, points, text=False):
    vertices = np.array([tuple(p) for p in points], dtype=[(axis, "f8") for axis in "xyz"])
    PlyData([PlyElement.describe(vertices, "vertex")], text=text).write(str(path))


def write_pts(path, points):
    rows = "".join(f"{x:.6f} {y:.6f} {z:.6f} -812 20 30 40\n" for x, y, z in points)
    path.write_text(f"{len(points)}\n{rows}")


def write_xyz(path, points):
    rows = "".join(f"{x:.6f},{y:.6f},{z:.6f}\n" for x, y, z in points)
    path.write_text(f"# x, y, z\nx,y,z\n{rows}")


WRITERS = {
    "a.e57": write_e57,
    "a.las": write_las,
    "a.laz": write_las,
    "a.ply": write_ply,
    "b.ply": lambda path, points: write_ply(path, points, text=True),
    "a.pts": write_pts,
    "a.xyz": write_xyz,
}


def imported(path, unit=LengthUnit.METRE):
    return import_cloud(ScanStation(name="S01", cloud=path, unit=unit), path.parent / "stations", silent)


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_points(tmp_path, points, name, monkeypatch):
    monkeypatch.setattr(cloud_readers, "POINTS_PER_RUN", 1000)  # several runs
    WRITERS[name](tmp_path / name, points)
    cloud = imported(tmp_path / name)
    read = station_points(cloud.path)
    assert (read.dtype, read.shape, cloud.points) == (np.float32, (2500, 3), 2500)
    assert isinstance(read, np.memmap)
    assert np.abs(read - points).max() < 6e-5  # the step of the .las file
    assert [path.name for path in (tmp_path / "stations").iterdir()] == ["S01.npy"]


def test_progress_is_told_while_reading(tmp_path, points, monkeypatch):
    monkeypatch.setattr(cloud_readers, "POINTS_PER_RUN", 1000)
    write_e57(tmp_path / "a.e57", points)
    told = []
    import_cloud(ScanStation(name="S01", cloud=tmp_path / "a.e57"), tmp_path, told.append)
    assert [(e.done, e.total, e.block) for e in told] == [(n, 2500, "S01") for n in (1000, 2000, 2500)]


def test_millimetres_become_metres(tmp_path, points):
    write_pts(tmp_path / "a.pts", points * 1000)
    assert (
        np.abs(station_points(imported(tmp_path / "a.pts", LengthUnit.MILLIMETRE).path) - points).max() < 1e-5
    )


def test_returns_that_never_came_are_dropped(tmp_path, points):
    write_xyz(tmp_path / "a.xyz", np.vstack([points[:100], np.zeros((7, 3)), points[100:]]))
    assert imported(tmp_path / "a.xyz").points == len(points)


def refusal(path, unit=LengthUnit.METRE):
    with pytest.raises(StageError) as caught:
        imported(path, unit)
    assert not list((path.parent / "stations").iterdir())
    return str(caught.value)


def test_a_wrong_unit_is_told_either_way(tmp_path, points):
    write_ply(tmp_path / "mm.ply", points * 1000)
    assert 'station[S01].unit = "mm"' in refusal(tmp_path / "mm.ply")
    write_ply(tmp_path / "m.ply", points)
    assert 'station[S01].unit = "m"' in refusal(tmp_path / "m.ply", LengthUnit.MILLIMETRE)


def test_a_national_grid_is_refused(tmp_path, points):
    write_las(tmp_path / "grid.las", points + np.array([40_000, 90_000, 0]))
    assert "scanner's own frame" in refusal(tmp_path / "grid.las")


@pytest.mark.parametrize("name", ["a.e57", "a.las", "a.laz", "a.ply", "a.pts"])
def test_a_truncated_file_is_refused(tmp_path, points, name):
    WRITERS[name](tmp_path / name, points)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) * 6 // 10])
    said = refusal(tmp_path / name)
    assert "S01" in said
    assert name in said
    assert said.count("\n") == 0


@pytest.mark.parametrize("name", WRITERS)
def test_a_cloud_without_points_is_refused(tmp_path, name):
    if name == "a.e57":  # the library writes none without points
        (tmp_path / name).write_bytes(b"")
    else:
        WRITERS[name](tmp_path / name, np.zeros((0, 3)))
    assert name in refusal(tmp_path / name)


def test_no_numbers_and_missing_columns_are_refused(tmp_path, points):
    broken = points.copy()
    broken[17, 1] = np.nan
    write_ply(tmp_path / "nan.ply", broken)
    assert "no numbers, 1 of 2500 points" in refusal(tmp_path / "nan.ply")
    (tmp_path / "two.xyz").write_text("1.0 2.0\n3.0 4.0\n")
    assert 'line 1 "1.0 2.0"' in refusal(tmp_path / "two.xyz")
    (tmp_path / "late.xyz").write_text("1.0 2.0 3.0\n4.0 5.0 6.0\n7.0 8.0\n")
    assert 'line 3 "7.0 8.0"' in refusal(tmp_path / "late.xyz")
