"""The model that people open is the measured ring: in place, closed, right side out, in its own colours."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.ring import Alignment, Ring
from pipeline.report.model import ring_cloud, ring_mesh, view_mesh
from tests.cable import scene

TRAVEL_M, CELL_M, TEXEL_M = 0.1, 0.0005, 0.0004
TEXTURE = scene.Texture(seed=6)


def oval(azimuth, y_m):
    """Two lobes of 0.3 mm on a cable that narrows by five per cent of the way."""
    return scene.RADIUS_M + 0.0003 * np.cos(2 * azimuth) - 0.05 * (y_m - 0.05)


def cells(side_m):
    columns = round(2 * np.pi * scene.RADIUS_M / side_m)
    return -np.pi + (np.arange(columns) + 0.5) * 2 * np.pi / columns, np.arange(0, TRAVEL_M, side_m)


@pytest.fixture(scope="module")
def ring():
    azimuth, y_m = cells(CELL_M)
    picture_azimuth, picture_y = cells(TEXEL_M)
    gray = TEXTURE(*np.meshgrid(picture_azimuth, picture_y))
    radius = oval(*np.meshgrid(azimuth, y_m)).astype(np.float32)
    return Ring(
        alignment=Alignment(rotation=np.eye(3), translation=np.zeros(3)),
        azimuth=azimuth,
        y_m=y_m,
        radius_m=radius,
        measured=np.ones(radius.shape, dtype=bool),
        picture=np.rint(gray[..., None] * scene.TINT).astype(np.uint8),
        picture_known=np.ones(gray.shape, dtype=bool),
        picture_y_m=picture_y,
        picture_azimuth=picture_azimuth,
        texel_mm=1000 * TEXEL_M,
    )


def holed(ring):
    """The ring with a hole of 10 x 10 mm, and where it is."""
    hole = (slice(80, 100), slice(300, 320))
    radius = ring.radius_m.copy()
    radius[hole] = np.nan
    return replace(ring, radius_m=radius), hole


def around(points):
    return np.arctan2(-points[:, 2], points[:, 0])


def away_mm(points):
    """Distance of points from the true surface, along the radius."""
    return 1000 * (np.hypot(points[:, 0], points[:, 2]) - oval(around(points), points[:, 1]))


def test_every_corner_lies_on_the_measured_surface(ring):
    mesh = ring_mesh(ring)
    error_mm = away_mm(mesh.vertices)
    inner = (mesh.vertices[:, 1] > 0.003) & (mesh.vertices[:, 1] < 0.096)
    assert np.abs(error_mm[inner]).max() < 0.002
    assert np.abs(error_mm).max() < 0.05  # averaging over the rim costs a little of the slope


@pytest.mark.parametrize("edge_mm", [1.0, 2.0])
def test_area_and_edges_are_as_wanted(ring, edge_mm):
    mesh = ring_mesh(ring, edge_mm)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    length = np.ptp(mesh.vertices[:, 1])
    assert area == pytest.approx(2 * np.pi * scene.RADIUS_M * length * np.sqrt(1 + 0.05**2), rel=0.002)
    assert 1000 * np.median(np.linalg.norm(b - a, axis=1)) == pytest.approx(edge_mm, rel=0.5)


@pytest.mark.parametrize("most", [500, 3000, 60_000])
def test_the_view_keeps_its_limit_and_the_surface(ring, most):
    mesh = view_mesh(ring, most)
    assert 0.5 * most < len(mesh.vertices) <= most
    # a chord's sagitta at the coarsest, and what averaging over cells takes of the rims' slope
    assert np.abs(away_mm(mesh.vertices)).max() < 0.4
    rise = np.ptp(mesh.vertices[:, 1]) / TRAVEL_M
    assert 0.85 < rise < 1
    u = mesh.uv[:, 0]
    left, right = (mesh.vertices[np.isclose(u, end)] for end in (u.min(), u.max()))
    assert len(left) > 5
    np.testing.assert_allclose(left, right, atol=1e-9)


def test_all_faces_and_normals_look_outward(ring):
    mesh = ring_mesh(ring)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    out = (a + b + c) * [1, 0, 1]
    assert (np.sum(np.cross(b - a, c - a) * out, axis=1) > 0).all()
    assert (np.sum(mesh.normals * mesh.vertices * [1, 0, 1], axis=1) > 0.04).all()


def test_the_surface_closes_where_the_picture_opens(ring):
    """The seam has two columns of corners at the same place, at either edge of the picture."""
    mesh = ring_mesh(ring)
    left = mesh.uv[:, 0] < 0.001
    right = mesh.uv[:, 0] > 1
    assert left.sum() == right.sum() == len(ring.y_m[::2])
    np.testing.assert_allclose(mesh.vertices[left], mesh.vertices[right], atol=1e-9)
    np.testing.assert_allclose(mesh.uv[left] + [1, 0], mesh.uv[right], atol=1e-9)


def test_every_corner_finds_its_own_texel(ring):
    mesh = ring_mesh(ring)
    height, width = ring.picture.shape[:2]
    column = (mesh.uv[:, 0] * width).astype(int) % width
    row = (mesh.uv[:, 1] * height).astype(int)
    assert row.min() >= 0
    assert row.max() < height
    turned = np.angle(np.exp(1j * (ring.picture_azimuth[column] - around(mesh.vertices))))
    assert scene.RADIUS_M * np.abs(turned).max() < 0.51 * TEXEL_M
    assert np.abs(ring.picture_y_m[row] - mesh.vertices[:, 1]).max() < 0.51 * TEXEL_M
    shown = mesh.texture[row, column].astype(float)  # red, green, blue
    truth = TEXTURE(around(mesh.vertices), mesh.vertices[:, 1])
    np.testing.assert_allclose(np.median(shown / truth[:, None], axis=0), scene.TINT[::-1], rtol=0.01)
    assert np.corrcoef(shown[:, 0], truth)[0, 1] > 0.99


def test_a_hole_stays_open(ring):
    with_hole, hole = holed(ring)
    mesh = ring_mesh(with_hole)
    azimuth, y_m = ring.azimuth[hole[1]], ring.y_m[hole[0]]
    inside = (np.abs(around(mesh.vertices) - azimuth.mean()) < np.ptp(azimuth) / 2) & (
        np.abs(mesh.vertices[:, 1] - y_m.mean()) < np.ptp(y_m) / 2
    )
    assert not inside.any()
    lost = len(ring_mesh(ring).faces) - len(mesh.faces)
    assert 2 * 10 * 10 <= lost <= 2 * 11 * 11
    assert np.abs(away_mm(mesh.vertices)).max() < 0.05  # the rim does not sink towards the hole


def test_the_cloud_is_every_measured_cell(ring):
    measured = ring.measured.copy()
    measured[:10] = False
    with_hole, _ = holed(replace(ring, measured=measured))
    cloud = ring_cloud(with_hole)
    assert len(cloud.points) == measured.sum() - 20 * 20
    np.testing.assert_allclose(
        np.hypot(cloud.points[:, 0], cloud.points[:, 2]),
        oval(around(cloud.points), cloud.points[:, 1]),
        atol=1e-8,
    )
    truth = TEXTURE(around(cloud.points), cloud.points[:, 1])
    assert np.corrcoef(cloud.colours[:, 0], truth)[0, 1] > 0.99
    np.testing.assert_allclose(np.median(cloud.colours / truth[:, None], axis=0), scene.TINT[::-1], rtol=0.01)


def test_normals_of_the_cloud_lean_with_the_taper(ring):
    """Radius falls by 0.05 a metre of way: normals lean forward by that tangent."""
    normals = ring_cloud(ring).normals
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    lean = normals[:, 1] / np.hypot(normals[:, 0], normals[:, 2])
    inner = slice(20 * ring.radius_m.shape[1], -20 * ring.radius_m.shape[1])
    np.testing.assert_allclose(lean[inner], 0.05, atol=0.002)


def test_normals_beside_a_hole_lean_no_more_than_elsewhere(ring):
    raised = replace(ring, radius_m=ring.radius_m + np.where(np.abs(ring.azimuth) < 1, 0.001, 0))
    with_hole, _ = holed(replace(raised, radius_m=raised.radius_m.astype(np.float32)))
    lean = np.abs(ring_cloud(with_hole).normals[:, 1])
    assert np.percentile(lean, 99.9) < 0.07
