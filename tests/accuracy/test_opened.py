"""A run folder read back is what the run found, whole or half finished."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from pipeline.core.errors import StageError
from pipeline.opened import open_run
from pipeline.report.block_model import block_mesh

BLOCKS = ["Block1", "Block2", "Block3", "Block4"]


@pytest.fixture(scope="module")
def opened(finished):
    return open_run(finished.folder)


@pytest.fixture
def copy(finished, tmp_path):
    """The finished run's products, to take things away from."""
    shutil.copytree(finished.folder / "products", tmp_path / "run" / "products")
    shutil.copytree(finished.folder / "blocks", tmp_path / "run" / "blocks")
    return tmp_path / "run"


def test_it_tells_the_diameters_of_the_report_to_the_last_digit(opened, report):
    assert [s.diameter_mm for s in opened.measurement.sections] == [
        s["diameter_mm"] for s in report["stations"]
    ]
    assert opened.report == report


def test_blocks_come_in_the_survey_s_order_with_their_figures(opened, report):
    assert [b.name for b in opened.blocks] == BLOCKS
    for block, told in zip(opened.blocks, report["blocks"], strict=True):
        assert block.orientation.reprojection_px == pytest.approx(told["reprojection_px"])
        assert block.orientation.lens.focal_px == pytest.approx(told["focal_px"])


def test_a_block_stands_where_its_placement_says(opened, finished):
    for block in opened.blocks:
        told = json.loads((finished.folder / "blocks" / block.name / "placement.json").read_text())
        assert np.allclose(block.cable_from_block, told["cable_from_block"], atol=1e-12)


def test_its_mesh_is_the_file_s(opened, finished):
    block = opened.blocks[1]
    made = block_mesh(block.surface, block.picture, block.crop.keep, opened.options.surface)
    written = trimesh.load(finished.folder / "blocks" / block.name / "mesh.ply", process=False)
    assert np.allclose(made.vertices, written.vertices, atol=1e-6)
    assert np.array_equal(made.faces, written.faces)


def test_half_a_run_opens_as_far_as_it_went(copy, opened):
    for name in ("closing", "joint", "mosaic", "ring", "measure"):
        (copy / "products" / f"all-{name}.npz").unlink()
    for block in BLOCKS:
        (copy / "products" / f"{block}-surface.stamp").unlink()  # it was being made when the power went
    half = open_run(copy)
    assert half.measurement is None
    assert half.ring is None
    assert half.report is None
    assert [b.surface for b in half.blocks] == [None] * 4
    assert all(b.orientation is not None for b in half.blocks)
    assert np.array_equal(half.blocks[0].cable_from_block, np.eye(4))
    assert not np.array_equal(half.blocks[0].orientation.points, opened.blocks[0].orientation.points)


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(StageError, match="is no run folder; choose a folder that a reconstruction wrote"):
        open_run(tmp_path)


def test_a_run_that_has_only_begun_is_refused(tmp_path):
    (tmp_path / "products").mkdir()
    with pytest.raises(StageError, match="nothing is finished in"):
        open_run(tmp_path)


def test_a_damaged_product_is_named(copy):
    (copy / "products" / "all-ring.npz").write_bytes(b"PK\x03\x04 no longer")
    with pytest.raises(StageError, match=r"all-ring\.npz of run is damaged or of another version"):
        open_run(copy)


def test_reading_it_back_loads_no_pycolmap(finished):
    """Blender reads products in its own process, where pycolmap must never be."""
    code = (
        "import pathlib, sys\n"
        "import pipeline.opened, pipeline.report.model\n"
        "pipeline.opened.open_run(pathlib.Path(sys.argv[1]))\n"
        "sys.exit('pycolmap' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(finished.folder)], check=False).returncode == 0
