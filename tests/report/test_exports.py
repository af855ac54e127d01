"""The exported files say what went in, read back by other hands: trimesh, json, csv, Pillow, struct."""

import csv
import json
import math
import struct

import numpy as np
import pytest
import trimesh
from PIL import Image

from pipeline.core.errors import StageError
from pipeline.report import exports
from pipeline.report.types import AxisSummary, Mesh
from tests.report import sample

CONTRACT_STATION = {
    "name", "position_m", "diameter_mm", "sigma_mm", "min_mm", "max_mm", "coverage_deg", "base_diameter_mm",
    "base_sigma_mm",
}  # fmt: skip
CONTRACT_BLOCK = {
    "name", "images", "calibrated", "keypoints_per_image", "reprojection_px", "focal_px", "division_lambda",
    "lambda_radius", "coverage_m2", "resolution_mm",
}  # fmt: skip


def read_json(path):
    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_report_json_has_the_keys_of_the_contract(tmp_path):
    tree = read_json(exports.write_report_json(tmp_path / "report.json", sample.report_data()))
    assert tree["format"] == 1
    assert tree["name"] == "stay-07"
    assert [set(station) for station in tree["stations"]] == [CONTRACT_STATION] * 4
    assert all(set(block) >= CONTRACT_BLOCK for block in tree["blocks"])
    assert tree["blocks"][0]["lambda_radius"] == "half-diagonal"
    assert set(tree["axis"]) == {"straightness_mm_per_m", "bow_mm", "profile"}
    assert tree["axis"]["straightness_mm_per_m"] == 0.214
    assert tree["timing_s"]["dense"] == 61.0
    assert tree["peak_memory_mb"] == 1834.0
    assert tree["unrolled"]["mm_per_px"] == 2.0


def test_report_json_tells_the_axis_place_by_place(tmp_path):
    axis = AxisSummary(
        straightness_mm_per_m=10.0,
        position_m=np.array([0.0, 0.1, 0.2]),
        bow_mm=np.array([[0.0, 0.0], [0.6, -0.8], [0.0, 0.0]]),
        centre_mm=np.array([[1.0, 2.0], [1.7, 1.2], [1.2, 2.0]]),
    )
    told = read_json(exports.write_report_json(tmp_path / "report.json", sample.report_data(axis=axis)))[
        "axis"
    ]
    assert told["bow_mm"] == pytest.approx(1.0)
    assert told["profile"][1] == {"position_m": 0.1, "x_mm": 1.7, "z_mm": 1.2}
    assert "bow_sigma_mm" not in told


def test_report_json_tells_the_sigma_of_the_bow_where_it_is_known(tmp_path):
    axis = AxisSummary(
        straightness_mm_per_m=10.0,
        position_m=np.array([0.0, 0.1, 0.2, 0.3]),
        bow_mm=np.array([[0.0, 0.0], [0.6, -0.8], [0.1, 0.2], [0.0, 0.0]]),
        centre_mm=np.zeros((4, 2)),
        sigma_mm=np.array([0.0, 0.15, 0.2, 0.0]),
    )
    data = sample.report_data(axis=axis)
    told = read_json(exports.write_report_json(tmp_path / "report.json", data))["axis"]
    assert told["bow_sigma_mm"] == 0.15
    assert [row["bow_sigma_mm"] for row in told["profile"]] == [0.0, 0.15, 0.2, 0.0]


def test_report_json_states_the_error_against_truth(tmp_path):
    tree = read_json(exports.write_report_json(tmp_path / "report.json", sample.report_data()))
    assert tree["truth"]["mean_absolute_error_mm"] == pytest.approx(0.037, abs=1e-9)
    by_name = {row["name"]: row["difference_mm"] for row in tree["truth"]["stations"]}
    assert by_name == pytest.approx(sample.DIFFERENCES_MM)
    assert tree["lens_effect"][0]["diameter_uncorrected_mm"] == 53.214
    assert not any(key.startswith("points") for key in tree["lens_effect"][0])


def test_what_is_not_known_is_null_and_never_nan(tmp_path):
    nothing = np.zeros((0, 2))
    axis = AxisSummary(
        straightness_mm_per_m=math.nan, position_m=np.zeros(0), bow_mm=nothing, centre_mm=nothing
    )
    data = sample.report_data(axis=axis, peak_memory_mb=math.nan, truth=())
    tree = read_json(exports.write_report_json(tmp_path / "report.json", data))
    assert tree["axis"] == {"straightness_mm_per_m": None, "bow_mm": None, "profile": []}
    assert tree["peak_memory_mb"] is None
    assert "truth" not in tree


def test_numpy_numbers_become_plain_numbers(tmp_path):
    data = sample.report_data(timing_s={"dense": np.float32(1.5)}, peak_memory_mb=np.int64(7))
    tree = read_json(exports.write_report_json(tmp_path / "report.json", data))
    assert tree["timing_s"] == {"dense": 1.5}
    assert tree["peak_memory_mb"] == 7


def test_diameters_csv_reads_as_a_table(tmp_path):
    data = sample.report_data()
    path = exports.write_diameters_csv(tmp_path / "diameters.csv", data.stations, data.truth)
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["A", "B", "C", "D"]
    assert float(rows[0]["diameter_mm"]) == pytest.approx(111.442, abs=1e-4)
    assert float(rows[3]["difference_mm"]) == pytest.approx(-0.057, abs=1e-4)


def test_diameters_csv_without_truth_has_only_the_station_columns(tmp_path):
    stations = (sample.station("测点, 1", 0.1, 111.0), sample.station("2", 0.2, math.nan))
    path = exports.write_diameters_csv(tmp_path / "diameters.csv", stations)
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == exports.STATION_FIELDS
    assert rows[0]["name"] == "测点, 1"
    assert rows[1]["diameter_mm"] == ""


@pytest.mark.parametrize("write", [exports.write_model_ply, exports.write_model_glb])
def test_the_model_comes_back_in_the_cable_frame(tmp_path, write):
    mesh = sample.cylinder_mesh()
    suffix = write.__name__.rpartition("_")[2]
    read = trimesh.load(write(tmp_path / f"model.{suffix}", mesh), force="mesh", process=False)
    assert np.allclose(read.vertices, mesh.vertices, atol=1e-6)
    assert np.array_equal(read.faces, mesh.faces)
    # Outward in the file too: an outward-facing tube encloses a positive volume.
    assert np.all(np.einsum("ij,ij->i", read.face_normals[:, [0, 2]], read.triangles_center[:, [0, 2]]) > 0)


def test_the_glb_texture_lies_where_uv_says(tmp_path):
    mesh = sample.cylinder_mesh()
    read = trimesh.load(exports.write_model_glb(tmp_path / "model.glb", mesh), force="mesh", process=False)
    picture = np.asarray(read.visual.material.baseColorTexture.convert("RGB")).astype(int)
    assert np.abs(picture - mesh.texture).mean() < 6.0
    # trimesh counts v upwards; the file, like our record, counts it downwards.
    assert np.allclose(read.visual.uv, np.stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]], axis=1), atol=1e-6)


def test_the_glb_is_laid_out_as_the_specification_says(tmp_path):
    payload = exports.write_model_glb(tmp_path / "model.glb", sample.cylinder_mesh()).read_bytes()
    magic, version, length = struct.unpack_from("<4sII", payload)
    assert (magic, version, length) == (b"glTF", 2, len(payload))
    json_length, json_type = struct.unpack_from("<I4s", payload, 12)
    assert json_type == b"JSON"
    assert json_length % 4 == 0
    tree = json.loads(payload[20 : 20 + json_length])
    blob_length, blob_type = struct.unpack_from("<I4s", payload, 20 + json_length)
    assert blob_type == b"BIN\0"
    assert tree["buffers"][0]["byteLength"] == blob_length
    assert all(view["byteOffset"] % 4 == 0 for view in tree["bufferViews"])
    view = tree["bufferViews"][tree["accessors"][1]["bufferView"]]
    start = 28 + json_length + view["byteOffset"]
    normals = np.frombuffer(payload[start : start + view["byteLength"]], dtype="<f4").reshape(-1, 3)
    assert np.allclose(normals, sample.cylinder_mesh().normals, atol=1e-6)
    box = tree["accessors"][0]
    assert box["max"][1] == pytest.approx(sample.LENGTH_M)
    assert box["min"][1] == pytest.approx(0)


def test_the_ply_model_carries_colours_from_the_texture(tmp_path):
    texture = np.zeros((2, 2, 3), dtype=np.uint8)
    texture[0, 0], texture[0, 1], texture[1, 0], texture[1, 1] = (
        (255, 0, 0),
        (0, 255, 0),
        (0, 0, 255),
        (9, 9, 9),
    )
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    mesh = Mesh(
        vertices=corners,
        normals=np.tile([0.0, 0, 1], (4, 1)),
        faces=np.array([[0, 1, 2], [1, 3, 2]]),
        uv=np.array([[0.0, 0], [1, 0], [0, 1], [1, 1]]),
        texture=texture,
    )
    payload = exports.write_model_ply(tmp_path / "model.ply", mesh).read_bytes()
    header, _, body = payload.partition(b"end_header\n")
    assert b"property float s\nproperty float t\nelement face 2" in header
    row = struct.Struct("<6f3B2f")
    rows = [row.unpack_from(body, index * row.size) for index in range(4)]
    assert [values[6:9] for values in rows] == [(255, 0, 0), (0, 255, 0), (0, 0, 255), (9, 9, 9)]
    # t counts upwards in PLY: the picture's top row is t = 1.
    assert [values[9:] for values in rows] == [(0, 1), (1, 1), (0, 0), (1, 0)]


def test_the_cloud_comes_back_with_normals_and_colours(tmp_path):
    cloud = sample.cylinder_cloud()
    path = exports.write_cloud_ply(tmp_path / "cloud.ply", cloud)
    read = trimesh.load(path)
    assert np.allclose(read.vertices, cloud.points, atol=1e-6)
    assert np.array_equal(read.colors[:, :3], cloud.colours)
    header, _, body = path.read_bytes().partition(b"end_header\n")
    assert header.startswith(b"ply\nformat binary_little_endian 1.0\n")
    normals = np.frombuffer(body, dtype=np.dtype([("v", "<f4", 6), ("c", "u1", 3)]))["v"][:, 3:]
    assert np.allclose(normals, cloud.normals, atol=1e-6)


def test_the_unrolled_picture_carries_its_scale(tmp_path):
    picture = sample.unrolled(mm_per_px=0.25)
    with Image.open(exports.write_unrolled_png(tmp_path / "unrolled.png", picture)) as read:
        read.load()
        assert np.array_equal(np.asarray(read), picture.image)
        assert float(read.text["mm_per_px"]) == 0.25
        assert float(read.text["theta_left_deg"]) == -60
        assert float(read.text["theta_right_deg"]) == 300
        assert (float(read.text["y_top_m"]), float(read.text["y_bottom_m"])) == (0, sample.LENGTH_M)
        # Printed at 100 % it is as large as the cable: 25.4 mm an inch over 0.25 mm a pixel.
        assert read.info["dpi"] == pytest.approx((101.6, 101.6), abs=0.05)


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StageError, match=r"report: cannot write .*file.report\.json"):
        exports.write_report_json(tmp_path / "file" / "report.json", sample.report_data())


def test_a_failed_write_leaves_the_old_file_and_no_rest(tmp_path):
    target = tmp_path / "report.json"
    target.mkdir()
    with pytest.raises(StageError):
        exports.write_report_json(target, sample.report_data())
    assert [path.name for path in tmp_path.iterdir()] == ["report.json"]


def test_writing_twice_gives_the_same_bytes(tmp_path):
    mesh = sample.cylinder_mesh()
    first = exports.write_model_glb(tmp_path / "1.glb", mesh).read_bytes()
    assert exports.write_model_glb(tmp_path / "2.glb", mesh).read_bytes() == first
