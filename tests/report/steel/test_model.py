"""Shapes are closed and where they belong; the files come back as they went in."""

import math

import numpy as np
import pytest
import trimesh

from pipeline.report.steel import model
from pipeline.report.steel.collect import collect
from pipeline.report.steel.directions import north_east_axes, wind
from pipeline.report.steel.scaling import round_factor
from pipeline.report.steel.shapes import arrow, ball, tube
from tests.report.steel import sample

RED = (255, 0, 0)


def solid(shape):
    return trimesh.Trimesh(shape.vertices, shape.faces, process=True)


def test_a_tube_is_closed_and_has_its_volume():
    mesh = solid(tube((1, 2, 3), (1, 2, 5), 0.1, RED, sides=64))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(2 * np.pi * 0.01, rel=0.002)
    assert mesh.bounds == pytest.approx(np.array([[0.9, 1.9, 3], [1.1, 2.1, 5]]), abs=0.001)


def test_a_ball_is_closed_and_has_its_volume():
    mesh = solid(ball((1, 1, 1), 0.5, RED, rings=40))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.125, rel=0.005)


def test_an_arrow_goes_from_start_to_end():
    shape = arrow((0, 0, 0), (2, 0, 0), 0.02, RED)
    assert shape.vertices[:, 0].min() == pytest.approx(0)
    assert shape.vertices[:, 0].max() == pytest.approx(2)
    assert solid(shape).volume > 0


@pytest.fixture(scope="module")
def report():
    return collect(sample.run(), {}, 0.0)


def test_the_models_parts_tell_how_much_they_are_enlarged(report):
    found = model.shapes(report)
    assert list(found) == ["rods", "balls", "columns", "eccentricity x50", "lean x50"]


def test_an_eccentricity_arrow_points_from_the_rods_to_the_ball(report):
    ((start, end),) = model.eccentricity_arrows(report)
    assert end - start == pytest.approx(50 * np.array([0.006, 0.008, 0.0]))


def test_a_lean_arrow_is_level_and_starts_at_the_top(report):
    row, (start, end) = model.lean_arrows(report)[0]
    assert start == pytest.approx(np.array(row.top_m))
    assert end - start == pytest.approx(50 * np.array([0.0321, -0.0173, 0.0]))  # north +x, east -y


def test_the_glb_comes_back_upright_for_gltf_with_named_parts(report, tmp_path):
    (tmp_path / "members.glb").write_bytes(model.glb_bytes(model.shapes(report)))
    scene = trimesh.load(tmp_path / "members.glb")
    assert {"rods", "balls", "columns"} <= set(scene.geometry)
    # z of the site is y in glTF
    assert scene.geometry["balls"].bounds[:, 1] == pytest.approx([5.9, 6.1], abs=1e-5)


def test_the_ply_comes_back_in_the_site_frame_with_colours(report, tmp_path):
    (tmp_path / "members.ply").write_bytes(model.ply_bytes(model.shapes(report)))
    mesh = trimesh.load(tmp_path / "members.ply")
    assert mesh.bounds[0][2] == pytest.approx(0.5, abs=0.01)
    assert {tuple(colour) for colour in mesh.visual.vertex_colors[:, :3].tolist()} >= {
        (213, 94, 0),
        (0, 158, 115),
    }


@pytest.mark.parametrize(
    ("largest_mm", "wanted_m", "factor"),
    [
        (10.0, 0.6, 50), (10.0, 0.5, 50), (10.0, 0.49, 20), (68.2, 2.0, 20),
        (0.0, 1.0, 1), (5000.0, 1.0, 1), (math.nan, 1.0, 1),
    ],
)  # fmt: skip
def test_small_things_are_drawn_a_round_number_of_times_larger(largest_mm, wanted_m, factor):
    assert round_factor(largest_mm, wanted_m) == factor


def test_winds_and_axes_follow_the_compass():
    assert [wind(a) for a in (0, 44, 91, 200, 359, math.nan)] == [
        "north", "north-east", "east", "south", "north", "nowhere",
    ]  # fmt: skip
    north, east = north_east_axes(90.0)
    assert north == pytest.approx((1.0, 0.0))
    assert east == pytest.approx((0.0, -1.0))
