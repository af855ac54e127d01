"""The record for the 3D view is the mesh, in few bytes."""

import base64
import json

import numpy as np
import pytest

from pipeline.report.viewer import ViewerOptions, viewer_record
from tests.report import sample


def decoded(text, kind, width):
    return np.frombuffer(base64.b64decode(text), dtype=kind).reshape(-1, width)


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
    with pytest.raises(ValueError, match="vertices"):
        viewer_record(sample.cylinder_mesh(rows=300, columns=300), (), ViewerOptions())
