"""The built library: assets, catalogues, pictures, and a second build that does nothing."""

import uuid

import bpy
import numpy as np
import pytest

from blend_assets.build import build
from blend_assets.catalogue import CATALOGUES

ASSETS = {"Cable", "Robot ring", "Black HDPE", "White HDPE", "Painted sheath", "Weathered sheath"}


@pytest.fixture
def assets(library):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(library / "cabletwin.blend"), assets_only=True) as (source, target):
        target.objects, target.materials = source.objects, source.materials
        target.collections = source.collections
    return {item.name: item for item in [*target.objects, *target.materials, *target.collections]}


def test_every_asset_is_there_and_tells_of_itself(assets):
    assert set(assets) == ASSETS
    known = {catalogue.uuid for catalogue in CATALOGUES}
    for item in assets.values():
        told = item.asset_data
        assert told.catalog_id in known
        assert told.license == "GPL-3.0-or-later"
        assert told.author
        assert len(told.description) > 10
        assert len(told.tags) >= 3


def test_every_asset_has_a_picture_of_something(assets):
    for item in assets.values():
        assert tuple(item.preview.image_size) == (256, 256)
        pixels = np.array(item.preview.image_pixels_float).reshape(-1, 4)
        assert 0.03 < (pixels[:, 3] > 0.5).mean() < 0.9
        assert pixels[pixels[:, 3] > 0.5][:, :3].std() > 0.01


def test_the_catalogue_file_is_one_that_blender_reads(library):
    head, version, *rest = (library / "blender_assets.cats.txt").read_text().splitlines()
    assert head.startswith("#")
    assert version == "VERSION 1"
    rows = [line.split(":") for line in rest if line]
    assert [(str(uuid.UUID(row[0])), row[1]) for row in rows] == [(c.uuid, c.path) for c in CATALOGUES]
    assert len({row[0] for row in rows}) == len(rows) == 3


def test_the_ring_looks_at_the_axis(assets):
    ring = assets["Robot ring"]
    bpy.context.scene.collection.children.link(ring)
    bpy.context.view_layer.update()
    cameras = sorted((o for o in ring.objects if o.type == "CAMERA"), key=lambda o: o.name)
    assert [camera.name for camera in cameras] == ["Block1", "Block2", "Block3", "Block4"]
    for number, camera in enumerate(cameras):
        placed = np.array(camera.matrix_world)
        angle = number * np.pi / 2
        assert placed[:3, 3] == pytest.approx([0.3 * np.cos(angle), 0, -0.3 * np.sin(angle)], abs=1e-6)
        assert -placed[:3, 2] == pytest.approx(-placed[:3, 3] / 0.3, abs=1e-6)  # looks along -z
        assert placed[:3, 0] == pytest.approx([0, 1, 0], abs=1e-6)  # travel to the right
    assert len([o for o in ring.objects if o.type == "LIGHT"]) == 4


def test_the_hardware_has_a_housing_for_each_camera(assets):
    ring = assets["Robot ring"]
    bpy.context.scene.collection.children.link(ring)
    hardware = next(o for o in ring.objects if o.type == "MESH")
    mesh = hardware.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    at = np.array([v.co for v in mesh.vertices])
    # nothing but four barrels reaches in to the cameras' centres
    inner = at[np.hypot(at[:, 0], at[:, 2]) < 0.31]
    angles = np.round(np.degrees(np.arctan2(-inner[:, 2], inner[:, 0])) / 90).astype(int) % 4
    assert set(angles) == {0, 1, 2, 3}
    assert np.hypot(at[:, 0], at[:, 2]).min() > 0.29


def test_a_second_build_has_nothing_to_do(library):
    before = (library / "cabletwin.blend").stat().st_mtime_ns
    assert build(library) == library
    assert (library / "cabletwin.blend").stat().st_mtime_ns == before
