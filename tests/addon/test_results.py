"""What is shown of a run is what the library reads: clouds, cameras, meshes, each in its own collection."""

import json
import time

import bpy
import cv2
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

from tests.addon.shown_run import library, named, objects, reloaded, show

MOST_SECONDS = 10.0
MANY_POINTS = 2_000_000


@pytest.fixture
def shown(rendered, copied, tmp_path):
    show(rendered, copied, tmp_path)
    return bpy.context.scene.cabletwin


@pytest.fixture
def run(copied):
    return library("pipeline.opened").open_run(copied)


def coordinates(data, attribute="position"):
    values = data.attributes[attribute].data
    found = np.empty(3 * len(values), dtype=np.float32)
    values.foreach_get("vector", found)
    return found.reshape(-1, 3)


def test_every_kind_of_thing_has_its_collection(shown, run):
    frames = sum(len(b.frames) for b in run.blocks)
    assert len(named("Sparse points")) == 4
    assert len(named("Cameras")) == frames
    assert set(objects("Block meshes")) == {"Block1", "Block2", "Block3", "Block4"}
    assert len(named("Mosaic")) == len(named("Dense cloud")) == 1


def test_the_panel_counts_points_and_things_and_not_objects(shown, run):
    base, room = library("panels.base"), library("results.collections")
    said = {
        kind: base.amount(kind, found, room)
        for kind in room.KINDS
        if (found := room.existing(bpy.context.scene, kind)) is not None
    }
    assert said["Sparse points"] == f"{sum(len(b.orientation.points) for b in run.blocks):,}"
    assert said["Cameras"] == str(sum(len(b.frames) for b in run.blocks))
    assert said["Block meshes"] == "4"
    assert said["Stations"] == str(len(shown.results.stations))
    assert said["Mosaic"] == said["Setup"] == ""


def test_the_dense_cloud_is_the_files(shown, run):
    cloud = library("pipeline.report.model").ring_cloud(run.ring)
    (made,) = named("Dense cloud").values()
    assert np.allclose(coordinates(made.data), cloud.points, atol=1e-6)
    rgba = np.empty(4 * len(cloud.points), dtype=np.float32)
    made.data.attributes["Col"].data.foreach_get("color_srgb", rgba)
    assert np.abs(255 * rgba.reshape(-1, 4)[:, :3] - cloud.colours).max() < 0.6


def test_a_solid_view_shows_the_clouds_mean_colour(shown, run):
    colours = library("pipeline.report.model").ring_cloud(run.ring).colours
    (made,) = named("Dense cloud").values()
    assert np.allclose(
        np.array(made.data.materials[0].diffuse_color[:3]) ** (1 / 2.2), colours.mean(axis=0) / 255, atol=0.01
    )
    assert [o.data.materials[0].diffuse_color[2] < 0.2 for o in named("Sparse points").values()] == [True] * 4


def test_a_large_cloud_is_thinned_evenly(run):
    points = run.blocks[0].orientation.points
    made = library("results.clouds").cloud_object("few", points, None, 0.001, 500)
    assert 250 < len(made.data.points) <= 500
    assert np.allclose(coordinates(made.data)[:, 1].mean(), points[:, 1].mean(), atol=0.01)


def test_block_meshes_stand_where_the_mosaic_put_them(shown, run):
    for block in run.blocks:
        made = objects("Block meshes")[block.name]
        assert np.allclose(np.array(made.matrix_world), block.cable_from_block, atol=1e-6)


def test_a_frame_matches_its_camera_to_a_pixel(shown, run):
    """Tie points, seen by Blender's camera, lie where they were measured in the picture behind it."""
    scene, block = bpy.context.scene, run.blocks[1]
    camera = next(o for o in bpy.data.objects if o.name == "Block2.004")
    picture = camera.data.background_images[0].image
    scene.render.resolution_x, scene.render.resolution_y = picture.size
    bpy.context.view_layer.update()
    placed = Matrix(block.cable_from_block.tolist())
    division = library("pipeline.core.division")
    orientation = block.orientation
    rows = np.flatnonzero(orientation.frame == 3)
    pinhole = division.undistorted_lens(orientation.lens)
    measured = division.rays_to_pixels(
        pinhole, division.pixels_to_rays(orientation.lens, orientation.pixels[rows])
    )
    seen = [
        world_to_camera_view(scene, camera, placed @ Vector(orientation.points[p]))
        for p in orientation.point[rows]
    ]
    away = np.array([(v.x * picture.size[0], (1 - v.y) * picture.size[1]) for v in seen]) - measured
    assert np.sqrt((away**2).mean()) < 0.2
    assert np.abs(away.mean(axis=0)).max() < 0.05


@pytest.mark.parametrize("size", [(960, 600), (600, 960)])
def test_a_camera_off_its_principal_point_projects_as_the_pinhole_does(size):
    """Shift has signs and a unit of its own in Blender; a centred lens would not tell."""
    lens = library("pipeline.core.vocabulary").Lens(
        width_px=size[0],
        height_px=size[1],
        focal_px=720.0,
        principal_point_px=(511.0, 262.0),
        division_lambda=0.0,
    )
    scene = bpy.context.scene
    turn = np.array(Matrix.Rotation(0.4, 3, (0.3, 0.8, -0.5)))
    camera = library("results.cameras").camera_object(
        "probe", lens, turn, np.array([0.1, -0.2, 0.9]), None, 0.02
    )
    scene.collection.objects.link(camera)
    scene.render.resolution_x, scene.render.resolution_y = size
    bpy.context.view_layer.update()
    for point in ((0.05, 0.02, 0.1), (-0.1, 0.2, -0.2), (0.2, 0.1, 0.3)):
        x, y, z = turn @ point + np.array([0.1, -0.2, 0.9])
        seen = world_to_camera_view(scene, camera, Vector(point))
        assert seen.x * size[0] == pytest.approx(720 * x / z + 511, abs=0.01)
        assert (1 - seen.y) * size[1] == pytest.approx(720 * y / z + 262, abs=0.01)


def test_the_picture_behind_a_camera_is_the_undistorted_frame(shown, run):
    camera = next(o for o in bpy.data.objects if o.name == "Block1.001")
    path = bpy.path.abspath(camera.data.background_images[0].image.filepath)
    assert cv2.imread(path).shape[1::-1] == tuple(camera.data.background_images[0].image.size)


def test_the_panel_tells_the_reports_figures(shown, finished):
    for item, told in zip(shown.results.stations, finished.report["stations"], strict=True):
        assert item.diameter_mm == pytest.approx(told["diameter_mm"], abs=1e-5)
        assert item.sigma_mm == pytest.approx(told["sigma_mm"], abs=1e-7)
    assert shown.results.mean_absolute_error_mm == pytest.approx(
        finished.report["truth"]["mean_absolute_error_mm"]
    )


def test_half_a_run_opens_as_far_as_it_went(rendered, copied, tmp_path):
    for name in ("mosaic", "ring", "measure"):
        (copied / "products" / f"all-{name}.stamp").unlink()
    (copied / "report.json").unlink()
    show(rendered, copied, tmp_path)
    assert len(named("Sparse points")) == len(objects("Block meshes")) == 4
    assert not named("Mosaic")
    assert not bpy.context.scene.cabletwin.results.finished


def test_a_folder_that_is_no_run_is_refused_and_what_is_shown_stays(shown, tmp_path):
    with pytest.raises(RuntimeError, match="is no run folder"):
        bpy.ops.cabletwin.results_choose(directory=str(tmp_path / "elsewhere"))
    assert len(named("Mosaic")) == 1


def test_opening_again_leaves_nothing_behind(shown):
    def counts():
        return {
            kind: len(getattr(bpy.data, kind))
            for kind in ("objects", "meshes", "pointclouds", "cameras", "materials", "images", "curves")
        }

    before = counts()
    bpy.ops.cabletwin.results_open()
    assert counts() == before


def test_it_survives_save_and_reload(shown, tmp_path):
    diameters = [s.diameter_mm for s in shown.results.stations]
    again = reloaded(tmp_path / "shown.blend")
    assert [s.diameter_mm for s in again.results.stations] == diameters
    (mesh,) = named("Mosaic").values()
    assert mesh.data.materials[0].node_tree is not None
    assert any(i.packed_file for i in bpy.data.images)


def test_two_million_points_take_less_than_ten_seconds(run):
    rng = np.random.default_rng(5)
    points = rng.normal(size=(MANY_POINTS, 3))
    colours = rng.integers(0, 256, (MANY_POINTS, 3), dtype=np.uint8)
    began = time.monotonic()
    made = library("results.clouds").cloud_object("many", points, colours, 0.001, MANY_POINTS)
    assert time.monotonic() - began < MOST_SECONDS
    assert len(made.data.points) == MANY_POINTS


def test_json_and_scene_agree_on_the_truth(shown, rendered):
    truth = {
        s["name"]: s["diameter_mm"] for s in json.loads((rendered / "truth.json").read_text())["stations"]
    }
    assert {s.name: round(s.truth_mm, 3) for s in shown.results.stations} == truth
