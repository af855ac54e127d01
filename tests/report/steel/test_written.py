"""A finished run folder holds the whole product; the cloud is thinned evenly and coloured by station."""

import json

import numpy as np
import pytest
from plyfile import PlyData

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.core.runfolder import RunFolder
from pipeline.report.steel import summary, write_steel_run
from pipeline.report.steel.cloud import write_cloud
from pipeline.steel.tile_records import RECORD, Tiles
from tests.report.steel import sample


def tiles(folder, counts=(4000, 1000)):
    """Two tiles of 4 m, the second negative; points on a line, of stations in turn."""
    folder.mkdir()
    cells = np.array([[0, 0, 0], [-1, 0, 0]])
    for cell, count in zip(cells, counts, strict=True):
        rows = np.zeros(count, dtype=RECORD)
        rows["place"][:, 0] = np.linspace(0, 3.999, count)
        rows["station"] = np.arange(count) % 5
        rows.tofile(folder / f"{cell[0]}_{cell[1]}_{cell[2]}.bin")
    stations = tuple(sample.pose(n) for n in range(5))
    return Tiles(
        folder=folder,
        tile_m=4.0,
        stations=stations,
        cells=cells,
        counts=np.array(counts),
        read_points=sum(counts),
    )


def test_the_run_folder_holds_everything_that_the_page_names(tmp_path):
    folder = RunFolder(tmp_path / "run")
    folder.note_time("register", "", 1.5)
    found = sample.run(tiles=tiles(tmp_path / "tiles"))
    report = write_steel_run(found, folder, None, "en", silent)
    present = {path.name for path in folder.path.iterdir()}
    assert present == {
        "report.json", "report.html", "stations.csv", "residuals.csv", "nodes.csv", "columns.csv",
        "deflection.csv", "members.glb", "members.ply", "cloud.ply", "products",
    }  # fmt: skip
    page = (folder.path / "report.html").read_text(encoding="utf-8")
    assert all(f'href="{name}"' in page for name in present - {"report.html", "products"})
    assert json.loads((folder.path / "report.json").read_text())["timing_s"]["report"] > 0
    assert report.timing_s["register"] == 1.5


def test_a_survey_of_target_lists_leaves_neither_model_nor_cloud(tmp_path):
    write_steel_run(sample.targets_only(), RunFolder(tmp_path), None, "zh", silent)
    assert {path.name for path in tmp_path.iterdir()} == {
        "report.json", "report.html", "stations.csv", "residuals.csv", "products",
    }  # fmt: skip


def test_the_truth_of_another_kind_is_refused(tmp_path):
    (tmp_path / "truth.json").write_text(json.dumps({"format": 1, "stations": []}))
    with pytest.raises(StageError, match='kind is not "steel"'):
        write_steel_run(sample.run(), RunFolder(tmp_path / "run"), tmp_path / "truth.json", "en", silent)


def test_the_cloud_is_thinned_evenly_over_its_tiles(tmp_path):
    told = []
    count = write_cloud(tmp_path / "cloud.ply", tiles(tmp_path / "tiles"), told.append, most_points=1000)
    rows = PlyData.read(tmp_path / "cloud.ply")["vertex"]
    assert count == len(rows) == 1000
    assert (rows["x"] < 0).sum() == 200  # a fifth of the points lie in the second tile
    assert rows["x"].min() == pytest.approx(-4.0)
    assert rows["x"].max() == pytest.approx(3.999, abs=0.01)
    assert len(told) == 2


def test_a_small_cloud_is_kept_whole_and_each_station_has_its_colour(tmp_path):
    assert write_cloud(tmp_path / "cloud.ply", tiles(tmp_path / "tiles"), silent) == 5000
    rows = PlyData.read(tmp_path / "cloud.ply")["vertex"]
    seen = {
        (s, r, g, b)
        for s, r, g, b in zip(rows["station"], rows["red"], rows["green"], rows["blue"], strict=True)
    }
    assert len(seen) == 5


def test_the_summary_names_what_a_person_must_know(tmp_path):
    text = summary(write_steel_run(sample.run(), RunFolder(tmp_path), None, "en", silent))
    assert "hall-3: 5 stations and 8 targets adjusted together, residual 1.00 mm (3D, rms)" in text
    assert "gross error: T03 was moved: S04, S05 see it 48.0 to 50.0 mm off" in text
    assert "gross error: what S02 calls T05 stands 5000.0 mm off it, it is T06" in text
    assert "2 of 3 columns lean more than they may" in text
    assert "1 of 5 nodes are eccentric, the most N001 by 10.0 mm" in text
    assert "largest deflection 9.5 mm at N003, within the limit of 24.0 mm" in text
    assert "note: S05 hangs on two targets alone." in text
