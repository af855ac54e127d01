"""The mesh for the 3D view is small, faithful, and whole at its seam."""

import base64
import json

import numpy as np
import pytest

from pipeline.report.viewer import ViewerOptions, reduced_mesh, viewer_record
from tests.report import sample


def decoded(text, kind, width):
    return np.frombuffer(base64.b64decode(text), dtype=kind).reshape(-1, width)


@pytest.fixture(scope="module")
def large():
    return sample.cylinder_mesh(rows=150, columns=300)


def test_a_small_mesh_is_kept_as_it_is():
    mesh = sample.cylinder_mesh()
    assert reduced_mesh(mesh, 100_000) is mesh


def test_the_reduced_mesh_keeps_limit_and_shape(large):
    small = reduced_mesh(large, 5000)
    assert 3500 < len(small.vertices) <= 5000
    radius = np.hypot(small.vertices[:, 0], small.vertices[:, 2])
    # The dents are 0.4 mm; averaging a cell may take the sagitta of its chord (0.02 mm) off.
    assert abs(np.mean(radius) - sample.RADIUS_M) < 5e-5
    assert np.all(np.abs(radius - sample.RADIUS_M) < 5e-4)
    assert np.allclose(np.linalg.norm(small.normals, axis=1), 1)


def test_the_reduced_mesh_still_faces_outward_everywhere(large):
    small = reduced_mesh(large, 5000)
    a, b, c = (small.vertices[small.faces[:, corner]] for corner in range(3))
    normal, middle = np.cross(b - a, c - a), (a + b + c) / 3
    assert np.all(np.einsum("ij,ij->i", normal[:, [0, 2]], middle[:, [0, 2]]) > 0)
    area = 0.5 * np.linalg.norm(normal, axis=1).sum()
    assert area == pytest.approx(2 * np.pi * sample.RADIUS_M * sample.LENGTH_M, rel=0.01)


def test_the_seam_stays_closed_and_the_ends_stay_where_they_were(large):
    small = reduced_mesh(large, 5000)
    assert small.uv.min(axis=0) == pytest.approx([0, 0], abs=1e-12)
    assert small.uv.max(axis=0) == pytest.approx([1, 1], abs=1e-12)
    left = small.vertices[small.uv[:, 0] < 1e-9]
    right = small.vertices[small.uv[:, 0] > 1 - 1e-9]
    assert len(left) == len(right) > 20
    assert np.allclose(left[np.argsort(left[:, 1])], right[np.argsort(right[:, 1])], atol=1e-9)
    assert np.ptp(small.vertices[:, 1]) == pytest.approx(sample.LENGTH_M, abs=1e-12)


def test_the_record_decodes_to_the_mesh():
    mesh = sample.cylinder_mesh()
    stations = (sample.station("A", 0.1, 111.4),)
    record = json.loads(viewer_record(mesh, stations, ViewerOptions(max_texture_px=64)))
    assert np.allclose(decoded(record["vertices"], "<f4", 3), mesh.vertices, atol=1e-6)
    assert np.allclose(decoded(record["normals"], "i1", 4)[:, :3] / 127, mesh.normals, atol=0.005)
    assert np.allclose(decoded(record["uv"], "<u2", 2) / 65535, mesh.uv, atol=1e-5)
    assert np.array_equal(decoded(record["indices"], "<u2", 3), mesh.faces)
    assert record["texture"].startswith("data:image/jpeg;base64,")
    ring = record["stations"][0]
    assert (ring["name"], ring["text"]) == ("A", "111.40 mm")
    assert ring["centre"] == pytest.approx([0.0002, 0.1, -0.0001])
    assert ring["radius"] == pytest.approx(0.0557)


def test_more_vertices_than_16_bits_are_refused():
    with pytest.raises(ValueError, match="max_vertices"):
        ViewerOptions(max_vertices=70_000)
