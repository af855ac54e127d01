"""What the run leaves for others: whole, true to scale, at its place and the right way round."""

import json
import re

import cv2
import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.interpolate import RegularGridInterpolator

from pipeline.__main__ import STAGE_NAMES

BLOCKS = ("Block1", "Block2", "Block3", "Block4")
LEAST_COVERAGE_DEG = 300
SURFACE_MM = 0.5


@pytest.fixture(scope="module")
def model(finished):
    return trimesh.load(finished.folder / "model.ply", process=False)


def azimuth_deg(points):
    """The contract's azimuth: (cos a, 0, -sin a)."""
    return np.degrees(np.arctan2(-points[:, 2], points[:, 0])) % 360


def true_radius_mm(truth, points):
    """Radius of the true cable at the places of these points; NaN beyond the travel."""
    known = truth["radius_mm"]
    theta = np.array([*known["theta_deg"], 360.0])
    values = np.array(known["values"])
    values = np.hstack([values, values[:, :1]])
    at = RegularGridInterpolator((known["position_m"], theta), values, bounds_error=False)
    return at((points[:, 1], azimuth_deg(points)))


class TestModel:
    def test_the_mesh_lies_on_the_true_cable(self, model, truth):
        radius_mm = 1000 * np.hypot(model.vertices[:, 0], model.vertices[:, 2])
        off_mm = radius_mm - true_radius_mm(truth, model.vertices)
        off_mm = off_mm[np.isfinite(off_mm)]
        assert len(off_mm) > 20_000
        assert np.abs(off_mm).max() < SURFACE_MM
        assert 0.005 < off_mm.std() < 0.15

    def test_the_mesh_stands_where_the_robot_passed(self, model, truth):
        y_m = model.vertices[:, 1]
        assert -0.03 < y_m.min() < 0.0
        assert truth["travel_m"] < y_m.max() < truth["travel_m"] + 0.03
        assert 5 * len(np.unique(azimuth_deg(model.vertices) // 5)) > LEAST_COVERAGE_DEG

    def test_the_faces_look_outwards(self, model):
        outward = model.triangles_center * [1, 0, 1]
        assert (np.sum(model.face_normals * outward, axis=1) > 0).mean() > 0.999

    def test_the_cloud_has_normals_that_look_outwards_and_colours(self, finished, truth):
        cloud = trimesh.load(finished.folder / "cloud.ply", process=False)
        raw = cloud.metadata["_ply_raw"]["vertex"]["data"]
        points = np.column_stack([raw[axis] for axis in "xyz"]).astype(float)
        normals = np.column_stack([raw[f"n{axis}"] for axis in "xyz"]).astype(float)
        outward = points * [1, 0, 1]
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        assert len(points) > 100_000
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3)
        assert np.sum(normals * outward, axis=1).min() > 0.7
        off_mm = 1000 * np.hypot(points[:, 0], points[:, 2]) - true_radius_mm(truth, points)
        assert np.nanpercentile(np.abs(off_mm), 99) < SURFACE_MM
        assert all(10 < raw[c].mean() < 245 and raw[c].std() > 3 for c in ("red", "green", "blue"))

    def test_the_glb_is_the_same_mesh_with_its_texture(self, finished, model):
        scene = trimesh.load(finished.folder / "model.glb")
        (mesh,) = scene.geometry.values()
        picture = mesh.visual.material.baseColorTexture
        np.testing.assert_allclose(mesh.bounds, model.bounds, atol=1e-5)
        assert len(mesh.faces) == len(model.faces)
        assert mesh.visual.uv.shape == (len(mesh.vertices), 2)
        # the outermost vertices stand half a texel beyond the picture
        assert -0.002 < mesh.visual.uv.min() < 0.01
        assert 0.99 < mesh.visual.uv.max() < 1.002
        assert min(picture.size) > 400
        assert np.asarray(picture.convert("L")).std() > 5


class TestUnrolledPicture:
    def test_its_scale_is_the_same_in_the_file_and_in_the_report(self, finished, report):
        picture = Image.open(finished.folder / "unrolled.png")
        told = {key: float(value) for key, value in picture.text.items()}
        assert told == pytest.approx(report["unrolled"])
        assert picture.size == (report["unrolled"]["width_px"], report["unrolled"]["height_px"])
        assert picture.info["dpi"][0] == pytest.approx(25.4 / report["unrolled"]["mm_per_px"], rel=1e-3)

    def test_its_sides_are_girth_and_length(self, report):
        u, diameter_mm = report["unrolled"], report["mean_diameter_mm"]
        turn = (u["theta_right_deg"] - u["theta_left_deg"]) / 360
        assert u["mm_per_px"] * u["width_px"] == pytest.approx(turn * np.pi * diameter_mm, rel=0.01)
        along_mm = 1000 * (u["y_bottom_m"] - u["y_top_m"])
        assert u["mm_per_px"] * u["height_px"] == pytest.approx(along_mm, rel=0.01)
        assert abs(turn) == pytest.approx(1, abs=0.01)

    def test_it_shows_the_cable_that_was_painted_at_its_place_and_not_mirrored(
        self, finished, rendered, report
    ):
        """The painting is synth's own (docs/synth.md); both are compared on a grid of azimuth and place."""
        azimuth, y_m = np.meshgrid(np.arange(0, 360, 0.5), np.arange(0.02, 0.28, 0.0005))
        shown = self.shown(finished, report["unrolled"], azimuth, y_m)
        same = correlation(shown, self.painted(rendered, azimuth, y_m))
        mirrored = correlation(shown, self.painted(rendered, -azimuth, y_m))
        reversed_ = correlation(shown, self.painted(rendered, azimuth, 0.30 - y_m))
        assert same > 0.7
        assert max(abs(mirrored), abs(reversed_)) < 0.4

    @staticmethod
    def shown(finished, u, azimuth, y_m):
        picture = np.asarray(Image.open(finished.folder / "unrolled.png").convert("L")).astype(np.float32)
        column = (azimuth - u["theta_left_deg"]) / (u["theta_right_deg"] - u["theta_left_deg"]) % 1
        row = (y_m - u["y_top_m"]) / (u["y_bottom_m"] - u["y_top_m"])
        return look_up(picture, row, column)

    @staticmethod
    def painted(rendered, azimuth, y_m):
        spec = json.loads((rendered / "truth.json").read_text())["spec"]
        picture = np.asarray(Image.open(rendered / ".synth" / "texture.png").convert("RGB").convert("L"))
        margin_m = spec["cable"]["margin_m"]
        length_m = spec["robot"]["travel_m"] + 2 * margin_m
        return look_up(picture[::-1].astype(np.float32), (y_m + margin_m) / length_m, azimuth / 360 % 1)


def look_up(picture, row, column):
    """Values at relative places 0 to 1, of the picture blurred to about a millimetre."""
    smooth = cv2.GaussianBlur(picture, (0, 0), 2.0)
    height, width = picture.shape
    x, y = (column * width - 0.5).astype(np.float32), (row * height - 0.5).astype(np.float32)
    return cv2.remap(smooth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def correlation(first, second):
    """Of what is smaller than 40 mm: light and dirt in the large do not count."""
    first, second = (p - cv2.GaussianBlur(p, (0, 0), 40.0) for p in (first, second))
    return np.corrcoef(first.ravel(), second.ravel())[0, 1]


class TestReport:
    def test_every_figure_of_the_contract_is_there(self, report):
        assert report["format"] == 1
        assert report["name"] == "paper"
        assert set(report) >= {"stations", "blocks", "axis", "timing_s", "peak_memory_mb"}
        station = {"name", "position_m", "diameter_mm", "sigma_mm", "min_mm", "max_mm", "coverage_deg"}
        block = {"name", "images", "calibrated", "keypoints_per_image", "reprojection_px", "focal_px"}
        block |= {"division_lambda", "lambda_radius", "coverage_m2", "resolution_mm"}
        assert all(set(s) >= station for s in report["stations"])
        assert all(set(b) >= block for b in report["blocks"])
        asked = [("A", 0.06), ("B", 0.12), ("C", 0.18), ("D", 0.24)]
        assert [(s["name"], s["position_m"]) for s in report["stations"]] == asked
        assert all(110 < s["diameter_mm"] < 112 for s in report["stations"])
        assert 0 < report["axis"]["straightness_mm_per_m"] < 1

    def test_time_and_memory_are_those_of_this_run(self, finished, report):
        timing_s = report["timing_s"]
        assert set(timing_s) == set(STAGE_NAMES)
        assert 0.5 * finished.command.seconds < sum(timing_s.values()) < finished.command.seconds
        assert 100 < report["peak_memory_mb"] < 4096

    def test_nothing_is_amiss(self, report):
        assert report["warnings"] == []

    def test_what_the_lens_correction_is_worth(self, report):
        """Figures 5 and 6 of the paper: each block alone, adjusted without and with the correction."""
        assert [e["block"] for e in report["lens_effect"]] == list(BLOCKS)
        for effect in report["lens_effect"]:
            assert 2 < effect["residual_uncorrected_mm"] / effect["residual_corrected_mm"] < 100
            assert 3 < effect["bow_uncorrected_mm"] < 20
            assert effect["bow_corrected_mm"] < 1
            assert 90 < effect["diameter_corrected_mm"] < 130

    def test_the_page_needs_nothing_beside_it(self, finished, report):
        page = (finished.folder / "report.html").read_text()
        outside = re.findall(r"""(?:src|href|url)\s*[=(]\s*["']?(?:https?:)?//[^"')\s>]+""", page)
        assert outside == []
        linked = set(re.findall(r"""(?:src|href)=["']([^"'#:]+)["']""", page))
        assert {name for name in linked if not (finished.folder / name).exists()} == set()
        for station in report["stations"]:
            assert f"{station['diameter_mm']:.3f}" in page

    def test_every_file_of_the_contract_is_there_and_nothing_unfinished(self, finished):
        files = ["report.json", "diameters.csv", "model.ply", "model.glb", "cloud.ply", "unrolled.png"]
        files += ["report.html"]
        inside = ["cloud.ply", "mesh.ply", "mesh_uncropped.ply"]
        inside += [f"sparse/{name}.bin" for name in ("cameras", "images", "points3D")]
        files += [f"blocks/{block}/{name}" for block in BLOCKS for name in inside]
        assert [name for name in files if not (finished.folder / name).stat().st_size] == []
        assert [p for p in finished.folder.rglob("*") if ".part" in p.name] == []
