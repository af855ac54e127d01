"""Every place, size and colour in the scene is the run's."""

import re
import shutil

import bpy
import numpy as np
import pytest

from tests.addon.shown_run import library
from tests.addon.steel import case
from tests.addon.steel.scene import colour, ends, named, told
from tests.command import ROOT

COLOURS = ROOT / "pipeline" / "report" / "steel" / "colours.py"


def test_every_kind_of_thing_has_its_collection_under_steel(shown, framed):
    report = told(framed)
    count = {name: len(named(name)) for name in [c.name for c in bpy.data.collections["Steel"].children]}
    stations = len(report["stations"])
    assert count == {
        "Stations": 2 * stations - 1,  # the base has no error ellipsoid
        "Targets": len(report["targets"]),
        "Cloud": 2,
        "Rods": 2,
        "Balls": 3,
        "Columns": 4,  # three judged, one that nobody asked for
        "Arrows": 2 + 3,
        "Gross errors": 4,
    }


def test_a_run_of_targets_only_shows_what_it_has(run):
    assert bpy.ops.cabletwin.steel_choose(directory=str(run)) == {"FINISHED"}
    assert len(named("Targets")) == len(told(run)["targets"])
    assert [named(kind) for kind in ("Rods", "Cloud", "Columns")] == [{}, {}, {}]


def test_stations_stand_and_face_as_the_adjustment_says(shown, framed):
    for station in told(framed)["stations"]:
        placed = np.array(named("Stations")[station["name"]].matrix_world)
        assert np.allclose(placed[:3, 3], station["position_m"], atol=1e-5)
        assert np.allclose(placed[:3, :3], station["rotation"], atol=1e-6)


def test_error_ellipsoids_have_the_covariance_s_axes_times_the_scale(shown, framed):
    shown.error_scale = 250
    for station in told(framed)["stations"][1:]:
        made = np.array(named("Stations")[f"{station['name']} error"].matrix_world)[:3, :3]
        drawn = made @ made.T / 250**2
        assert np.allclose(1e6 * drawn, station["covariance_mm2"], rtol=1e-3, atol=2e-3)


def test_balls_and_rods_stand_where_they_were_fitted(shown):
    for name in case.APART_MM:
        ball = named("Balls")[name]
        assert np.allclose(ball.matrix_world.translation, case.ball_place(name), atol=1e-6)
        assert ball.dimensions.x == pytest.approx(0.2, rel=0.01)
    low, high = ends(named("Rods")["R01"])
    assert np.allclose((low, high), (case.ball_place("N01"), case.ball_place("N02")), atol=1e-6)


@pytest.mark.parametrize("name", list(case.LEAN_MM))
def test_columns_lean_as_they_do(shown, name):
    low, high = ends(named("Columns")[name])
    assert np.allclose(low, (*case.PLACES[name], 0), atol=1e-6)
    assert np.allclose(high, case.top_place(name), atol=1e-6)


def test_clouds_hold_the_files_points_in_the_stations_colours(shown, framed):
    names = [station["name"] for station in told(framed)["stations"]]
    shapes = library("results.steel_points")
    for number, points in enumerate(case.cloud_points()):
        cloud = named("Cloud")[f"{names[number]} points"]
        found = np.empty(3 * len(points), dtype=np.float32)
        cloud.data.attributes["position"].data.foreach_get("vector", found)
        assert np.allclose(found.reshape(-1, 3), points, atol=1e-6)
        painted = cloud.data.materials[0].diffuse_color
        assert tuple(painted) == pytest.approx(shapes.linear(*case.STATION_COLOURS[number]), abs=1e-6)


def test_a_large_cloud_is_thinned_evenly(framed):
    made = library("results.steel_points").station_clouds(framed, ("A", "B"), 100)
    assert [len(item.data.points) for item in made] == [70, 30]


@pytest.mark.parametrize(
    ("kind", "name", "verdict"),
    [
        ("Columns", "A-1", "BAD"),
        ("Columns", "A-2", "GOOD"),
        ("Columns", "B-1", "UNSURE"),
        ("Columns", "C02", "UNKNOWN"),
        ("Balls", "N01", "GOOD"),
        ("Balls", "N02", "BAD"),
        ("Rods", "R01", "STEEL"),
    ],
)
def test_a_colour_is_the_verdict_and_the_reports(shown, kind, name, verdict):
    # read and not imported: the report brings pycolmap with it, which must not come into this process
    (told_hex,) = re.findall(rf'^{verdict} = "#(\w+)"', COLOURS.read_text(), re.MULTILINE)
    wanted = library("results.steel_points").linear(*bytes.fromhex(told_hex))
    assert colour(named(kind)[name]) == pytest.approx(wanted, abs=1e-6)


def test_arrows_are_true_times_the_scale_and_follow_it_without_the_run(shown, framed):
    shutil.rmtree(framed)
    for scale in (50, 120):
        shown.arrow_scale = scale
        for name in ("N02", "N03"):
            low, high = ends(named("Arrows")[f"{name} eccentricity"])
            apart_m = np.array(case.APART_MM[name]) / 1000
            assert np.allclose(low, case.ball_place(name) - apart_m, atol=1e-6)
            assert np.allclose(high - low, scale * apart_m, atol=1e-5)
        for name, lean_mm in case.LEAN_MM.items():
            low, high = ends(named("Arrows")[f"{name} lean"])
            assert np.allclose(high - low, scale * np.array([*lean_mm, 0]) / 1000, atol=1e-5)
    assert "N01 eccentricity" not in named("Arrows")


def test_gross_errors_are_marked_at_their_targets(shown, framed):
    places = {target["name"]: target["position_m"] for target in told(framed)["targets"]}
    moved = named("Gross errors")["T15 moved"]
    assert np.allclose(moved.matrix_world.translation, places["T15"], atol=1e-5)
    offset = named("Gross errors")["T15 offset"]
    shown.arrow_scale = 10
    bpy.context.view_layer.update()
    low, high = ends(offset)
    assert 10 * 0.047 < np.linalg.norm(high - low) < 10 * 0.053
    wrong = next(g for g in told(framed)["gross"] if g["kind"] == "misnamed")
    low, high = ends(named("Gross errors")[f"{wrong['target']} offset"])
    assert np.linalg.norm(high - low) == pytest.approx(wrong["size_mm"] / 1000, rel=1e-5)


def test_what_photos_added_is_shown_in_its_own_colours(framed):
    names = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
    rows = np.zeros(5, dtype=np.dtype([*names, ("origin", "<i2"), ("intensity", "<f4")]))
    rows["origin"] = (0, -1, -1, 1, -1)
    rows["x"], rows["red"] = range(5), 128
    words = ["float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"]
    told = [f"property {word}" for word in (*words, "short origin", "float intensity")]
    head = ["ply", "format binary_little_endian 1.0", "element vertex 5", *told, "end_header\n"]
    (framed / "merged.ply").write_bytes("\n".join(head).encode() + rows.tobytes())
    assert bpy.ops.cabletwin.steel_choose(directory=str(framed)) == {"FINISHED"}
    cloud = named("Cloud")["Photo points"].data
    assert [round(point.co.x) for point in cloud.points] == [1, 2, 4]
    assert cloud.attributes["Col"].data[0].color_srgb[0] == pytest.approx(128 / 255, abs=1e-3)
