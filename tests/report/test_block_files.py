"""Each block's own files read back as what the block is, by COLMAP's own reader and a mesh library."""

import json
from pathlib import Path

import cv2  # noqa: F401 - before pycolmap: the other way round the two libraries' PNG writers collide
import numpy as np
import pycolmap
import pytest
import trimesh

from pipeline.cable.records import BlockRun, CableOptions, CableRun
from pipeline.cable.ring import Alignment
from pipeline.cable.surface import SurfaceOptions
from pipeline.cable.survey import Block, LensSpec
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import TravelDirection
from pipeline.report.block_files import write_block_files
from tests.cable import pieces, scene

TEXTURE = scene.Texture(seed=3)
FRAMES = 6


@pytest.fixture(scope="module")
def view():
    return scene.Scene(
        poses=scene.poses(frames=FRAMES, sway_deg=0.2, sway_mm=0.5), lens=scene.lens(scene.BARREL)
    )


def block_run(name, number, view, crop_columns):
    """One block; what its files do not tell (lens solution, POS, tie points, radius map) is left out."""
    joined, crop = pieces.block(90.0 * number, pieces.ASTRAY[number], texture=TEXTURE)
    keep = crop.keep.copy()
    keep[:, :crop_columns] = False
    return BlockRun(
        block=Block(
            name=name,
            source=f"{name}.mp4",
            angle_deg=90.0 * number,
            travel_in_image=TravelDirection.RIGHT,
            lens_spec=LensSpec(focal_px=scene.FOCAL_PX),
        ),
        frames=scene.sequence([Path(name) / f"{k:06d}.png" for k in range(FRAMES)], name),
        lens=None,
        pos=None,
        tie_points=None,
        orientation=scene.true_orientation(view),
        dense=None,
        surface=joined.surface,
        picture=joined.picture,
        crop=type(crop)(keep=keep, incidence_deg=crop.incidence_deg),
    )


@pytest.fixture(scope="module")
def alignment():
    return Alignment(
        rotation=np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), translation=np.array([0.01, 0, -0.02])
    )


@pytest.fixture(scope="module")
def run(view, alignment, tmp_path_factory):
    return CableRun(
        survey=None,
        options=CableOptions(surface=SurfaceOptions(mesh_mm=1.6)),
        blocks=tuple(block_run(n, k, view, 30) for k, n in enumerate(("North", "East"))),
        together=None,
        mosaic=pieces.placed(pieces.ASTRAY[:2]),
        ring=type("RingStandsHere", (), {"alignment": alignment})(),
        measurement=None,
    )


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "blocks"
    for number in range(len(run.blocks)):
        write_block_files(run, number, folder)
    return folder


@pytest.fixture(scope="module")
def model(folder):
    return pycolmap.Reconstruction(str(folder / "North" / "sparse"))


def test_every_block_has_its_files_and_nothing_half_written(folder):
    assert sorted(p.name for p in folder.iterdir()) == ["East", "North"]
    for block in folder.iterdir():
        assert sorted(p.name for p in block.iterdir()) == [
            "cloud.ply",
            "mesh.ply",
            "mesh_uncropped.ply",
            "placement.json",
            "sparse",
        ]


def test_colmap_reads_the_lens_it_calls_simple_division(model):
    (camera,) = model.cameras.values()
    assert camera.model.name == "SIMPLE_DIVISION"
    assert (camera.width, camera.height) == (scene.WIDTH_PX, scene.HEIGHT_PX)
    k = scene.BARREL * (scene.FOCAL_PX / scene.HALF_DIAGONAL_PX) ** 2
    np.testing.assert_allclose(camera.params, [scene.FOCAL_PX, 160, 100, k])


def test_colmap_reads_every_image_where_it_was_taken(model, view):
    images = sorted(model.images.values(), key=lambda image: image.name)
    assert [image.name for image in images] == [f"{k:06d}.png" for k in range(FRAMES)]
    for k, image in enumerate(images):
        pose = image.cam_from_world()
        np.testing.assert_allclose(pose.rotation.matrix(), view.poses.rotations[k], atol=1e-9)
        np.testing.assert_allclose(pose.translation, view.poses.translations[k], atol=1e-12)


def test_colmap_s_own_projection_of_the_points_gives_the_measurements(model, run):
    """Points, tracks, poses and lens fit together in COLMAP's own arithmetic."""
    orientation = run.blocks[0].orientation
    worst, seen = 0.0, 0
    for image in model.images.values():
        for point2d in image.points2D:
            assert point2d.has_point3D()
            point = model.points3D[point2d.point3D_id]
            projected = image.project_point(point.xyz)
            worst = max(worst, float(np.linalg.norm(projected - point2d.xy)))
            seen += 1
    assert seen == len(orientation.frame)
    assert worst < 1e-6


def test_colmap_reads_the_tracks_as_they_were_measured(model, run):
    orientation = run.blocks[0].orientation
    observed = np.unique(orientation.point)
    assert model.num_points3D() == len(observed)
    lengths = sorted(p.track.length() for p in model.points3D.values())
    assert lengths == sorted(np.bincount(orientation.point)[observed].tolist())
    found = np.array(sorted(p.xyz.tolist() for p in model.points3D.values()))
    np.testing.assert_allclose(found, sorted(orientation.points[observed].tolist()))


def mesh(folder, block, name):
    return trimesh.load(folder / block / name, process=False)


def test_the_meshes_are_the_surface_before_and_after_cropping(folder, run):
    whole, cropped = (mesh(folder, "North", n) for n in ("mesh_uncropped.ply", "mesh.ply"))
    surface = run.blocks[0].surface
    truth_m2 = np.ptp(surface.y_m) * np.ptp(surface.azimuth) * np.median(surface.radius_m)
    assert 0.975 * truth_m2 < whole.area <= 1.001 * truth_m2  # less than one edge is lost at each border
    share = 1 - 30 / surface.radius_m.shape[1]
    assert cropped.area / whole.area == pytest.approx(share, abs=0.015)
    edges = np.linalg.norm(np.diff(whole.vertices[whole.faces[:, :2]], axis=1)[:, 0], axis=1)
    assert np.median(edges) == pytest.approx(0.0016, rel=0.45)


def test_the_mesh_stands_in_the_block_s_own_frame(folder, run):
    """Brought to its true place, it lies on the cable; as it stands, it is astray."""
    vertices = mesh(folder, "North", "mesh.ply").vertices
    inner = (vertices[:, 1] > 0) & (vertices[:, 1] < pieces.TRAVEL_M)
    own = np.hypot(vertices[inner, 0], vertices[inner, 2])
    placed = pieces.ASTRAY[0].apply(vertices[inner])
    true = np.hypot(placed[:, 0], placed[:, 2])
    assert 1000 * np.abs(own - scene.RADIUS_M).max() > 0.2
    assert 1000 * np.abs(true - scene.RADIUS_M).max() < 0.01


def test_the_placement_brings_the_block_into_the_joined_model(folder, run, alignment):
    for number, name in enumerate(("North", "East")):
        document = json.loads((folder / name / "placement.json").read_text())
        matrix = np.array(document["cable_from_block"])
        points = mesh(folder, name, "mesh.ply").vertices[::50]
        moved = points @ matrix[:3, :3].T + matrix[:3, 3]
        truth = pieces.ASTRAY[number].apply(points) @ alignment.rotation.T + alignment.translation
        np.testing.assert_allclose(moved, truth, atol=1e-12)
        np.testing.assert_array_equal(matrix[3], [0, 0, 0, 1])
        assert document["scale"] == pytest.approx(pieces.ASTRAY[number].scale)
        assert document["format"] == 1


def shown(vertices, motion):
    """The true brightness at points of a displaced block."""
    placed = motion.apply(np.asarray(vertices))
    return TEXTURE(np.arctan2(-placed[:, 2], placed[:, 0]), placed[:, 1])


def written_colours(mesh):
    """Vertex colours as they stand in the file; the library itself prefers the texture coordinates."""
    rows = mesh.metadata["_ply_raw"]["vertex"]["data"]
    return np.stack([rows[name] for name in ("red", "green", "blue")], axis=1)


def test_mesh_and_cloud_carry_the_surface_s_own_colours(folder):
    for name, motion in (("North", pieces.ASTRAY[0]), ("East", pieces.ASTRAY[1])):
        coloured = mesh(folder, name, "mesh.ply")
        cloud = trimesh.load(folder / name / "cloud.ply")
        for places, colours in (
            (coloured.vertices, written_colours(coloured)),
            (cloud.vertices, cloud.colors),
        ):
            truth = shown(places, motion)
            red_green_blue = np.asarray(colours)[:, :3].astype(float)
            assert np.corrcoef(red_green_blue[:, 0], truth)[0, 1] > 0.97
            np.testing.assert_allclose(
                red_green_blue.mean(axis=0) / truth.mean(), scene.TINT[::-1], rtol=0.01
            )


def test_the_cloud_holds_every_measured_cell(folder, run):
    cloud = trimesh.load(folder / "East" / "cloud.ply")
    surface = run.blocks[1].surface
    assert len(cloud.vertices) == surface.measured.sum()
    np.testing.assert_allclose(np.asarray(cloud.vertices)[5], surface.points()[0, 5], atol=1e-7)


def test_writing_again_replaces_the_files(run, folder, tmp_path):
    for _ in range(2):
        write_block_files(run, 0, tmp_path)
    assert sorted(p.name for p in (tmp_path / "North" / "sparse").iterdir()) == sorted(
        p.name for p in (folder / "North" / "sparse").iterdir()
    )
    assert (tmp_path / "North" / "mesh.ply").read_bytes() == (folder / "North" / "mesh.ply").read_bytes()


def test_a_folder_that_cannot_be_written_is_refused(run, tmp_path):
    (tmp_path / "blocks").write_text("in the way")
    with pytest.raises(StageError, match=r"cannot write .*; choose another folder or make room there"):
        write_block_files(run, 0, tmp_path / "blocks")
