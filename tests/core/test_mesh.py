"""Grids of surface points become sound triangles: right area, right side out, holes left open."""

from collections import Counter

import numpy as np
import pytest

from pipeline.core import mesh as surface_mesh
from pipeline.core.mesh import mesh_of_grid

RADIUS_M, LENGTH_M = 0.05, 0.1


def tube(rows=21, columns=181, first=-np.pi, last=np.pi):
    azimuth, y = np.linspace(first, last, columns), np.linspace(0, LENGTH_M, rows)
    a, along = np.meshgrid(azimuth, y)
    outward = np.stack([np.cos(a), 0 * a, -np.sin(a)], axis=-1)
    return RADIUS_M * outward + along[..., None] * [0, 1, 0], outward


def areas(mesh):
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def edges(mesh):
    """How often each directed edge is used."""
    pairs = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    return Counter(map(tuple, pairs.tolist()))


def test_the_area_is_that_of_the_cylinder():
    points, outward = tube()
    mesh = mesh_of_grid(points, np.ones(points.shape[:2], dtype=bool), outward)
    area = np.linalg.norm(areas(mesh), axis=1).sum()
    truth = 2 * np.pi * RADIUS_M * LENGTH_M
    assert 0.9995 * truth < area < truth  # chords are shorter than arcs


@pytest.mark.parametrize("columns", ["growing azimuth", "falling azimuth"])
def test_faces_and_normals_point_outward(columns):
    points, outward = tube(first=-1, last=1)
    if columns == "falling azimuth":
        points, outward = points[:, ::-1], outward[:, ::-1]
    mesh = mesh_of_grid(points, np.ones(points.shape[:2], dtype=bool), outward)
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    assert (np.sum(areas(mesh) * middles * [1, 0, 1], axis=1) > 0).all()
    truth = mesh.vertices * [1, 0, 1] / RADIUS_M
    assert np.sum(mesh.normals * truth, axis=1).min() > np.cos(np.deg2rad(1.0))
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1)


def test_normals_summed_run_by_run_are_those_of_all_faces_at_once(monkeypatch):
    points, outward = tube()
    whole = mesh_of_grid(points, np.ones(points.shape[:2], dtype=bool), outward)
    monkeypatch.setattr(surface_mesh, "FACES_PER_RUN", 70)
    in_runs = mesh_of_grid(points, np.ones(points.shape[:2], dtype=bool), outward)
    np.testing.assert_allclose(in_runs.normals, whole.normals, atol=1e-12)


def test_a_hole_takes_away_the_triangles_that_touch_it_and_no_other():
    points, outward = tube(rows=5, columns=6, first=-1, last=1)
    stands = np.ones((5, 6), dtype=bool)
    whole = mesh_of_grid(points, stands, outward)
    stands[2, 3] = False
    holed = mesh_of_grid(points, stands, outward)
    assert len(whole.faces) == 2 * 4 * 5
    assert len(whole.faces) - len(holed.faces) == 6
    assert 2 * 6 + 3 not in holed.cells


def test_vertices_are_the_cells_they_say_they_are():
    points, outward = tube(rows=5, columns=6, first=-1, last=1)
    stands = np.random.default_rng(3).random((5, 6)) < 0.8
    mesh = mesh_of_grid(points, stands, outward)
    np.testing.assert_array_equal(mesh.vertices, points.reshape(-1, 3)[mesh.cells])
    assert stands.ravel()[mesh.cells].all()
    assert set(mesh.faces.ravel().tolist()) == set(range(len(mesh.vertices)))


def test_a_closed_ring_has_no_seam():
    points, outward = tube(columns=36, last=np.pi * (1 - 2 / 36))
    mesh = mesh_of_grid(points, np.ones(points.shape[:2], dtype=bool), outward, closed=True)
    directed = edges(mesh)
    assert max(directed.values()) == 1, "two faces turn the same way about an edge"
    border = [edge for edge in directed if edge[::-1] not in directed]
    assert len(border) == 2 * 36  # the two open ends and nothing else
    assert len(mesh.vertices) == 21 * 36


def test_nothing_that_stands_gives_an_empty_mesh():
    points, outward = tube(rows=3, columns=4)
    mesh = mesh_of_grid(points, np.zeros((3, 4), dtype=bool), outward)
    assert mesh.vertices.shape == mesh.normals.shape == mesh.faces.shape == (0, 3)
