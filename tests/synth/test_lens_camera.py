"""Cycles traces the division lens exactly: silhouette and depth of a plain cylinder in closed form.

The formulas stand here once more, written for a camera square to the cylinder, so that neither synth's truth
nor its renderer judges itself.
"""

import signal
import threading
from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.errors import StageError
from synth.lens import block_lenses
from synth.lens_camera import check_rays
from synth.motion import block_poses
from synth.scene import build_scene, lamps_in_ring
from synth.spec import Cable, LensSpec, Robot, Sensor, Spec
from synth.tracer import Moment, trace

STANDOFF_M, RADIUS_M = 0.30, 0.055
WIDTH, HEIGHT, FOCAL = 160, 100, 120.0
HALF_DIAGONAL = np.hypot(WIDTH, HEIGHT) / 2.0


def survey(division_lambda, **robot):
    return Spec(
        cable=Cable(diameter_mm=2000.0 * RADIUS_M),
        robot=Robot(standoff_m=STANDOFF_M, travel_m=0.1, frames=2, angles_deg=(90.0,), **robot),
        lens=LensSpec(focal_px=FOCAL, width_px=WIDTH, height_px=HEIGHT, division_lambda=division_lambda),
        sensor=Sensor(samples=1),  # the first ray goes through the pixel's centre,
    )


def moment(spec, frame=0):
    (poses,) = block_poses(spec)
    return Moment(
        lens=block_lenses(spec)[0],
        rotation=poses.rotations[frame],
        translation=poses.translations[frame],
        lamps_in_world=lamps_in_ring(spec),
        seed=1,
        samples=spec.sensor.samples,
        name="Block1 frame 0",
    )


def viewing_slopes(division_lambda):
    """x / z and y / z of the ray through each pixel's centre, equation (15) in half-diagonals."""
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT) + 0.5 - HEIGHT / 2)
    divisor = 1.0 + division_lambda * (x**2 + y**2) / HALF_DIAGONAL**2
    return x / divisor / FOCAL, y / divisor / FOCAL


@pytest.fixture(scope="module", params=[0.0, -0.02, -0.25, 0.1])
def traced(request, tmp_path_factory):
    spec = survey(request.param)
    light, depth = trace(build_scene(spec, None), moment(spec), tmp_path_factory.mktemp("render"))
    return request.param, light, depth


def test_the_silhouette_is_the_bent_image_of_two_straight_edges(traced):
    division_lambda, _, depth = traced
    _, slope = viewing_slopes(division_lambda)
    edge = RADIUS_M / np.sqrt(
        STANDOFF_M**2 - RADIUS_M**2
    )  # tangent of the half angle under which the cable is seen
    off_edge_px = FOCAL * (np.abs(slope) - edge)
    clear = np.abs(off_edge_px) > 0.03
    assert np.array_equal((depth > 0.0)[clear], (off_edge_px < 0.0)[clear])
    assert clear.mean() > 0.99


def test_the_width_in_the_middle_column(traced):
    division_lambda, _, depth = traced
    edge = RADIUS_M / np.sqrt(STANDOFF_M**2 - RADIUS_M**2)
    # y = u (1 + k y^2) with u the undistorted edge in pixels and k per square pixel: the smaller root
    u, k = edge * FOCAL, division_lambda / HALF_DIAGONAL**2
    y_px = u if k == 0.0 else (1.0 - np.sqrt(1.0 - 4.0 * k * u * u)) / (2.0 * k * u)
    rows = np.count_nonzero(depth[:, WIDTH // 2])
    assert rows == pytest.approx(2.0 * y_px, abs=1.0)
    assert 40 < rows < 50


def test_the_depth_is_that_of_a_cylinder_at_every_pixel(traced):
    division_lambda, _, depth = traced
    _, slope = viewing_slopes(division_lambda)
    # (z s)^2 + (z - D)^2 = r^2 for the nearer z
    root = STANDOFF_M**2 - (1.0 + slope**2) * (STANDOFF_M**2 - RADIUS_M**2)
    seen = root > 0.0
    expected_m = (STANDOFF_M - np.sqrt(root[seen])) / (1.0 + slope[seen] ** 2)
    met = depth[seen] > 0.0  # the mesh may miss the very limb
    off_along_normal_m = np.abs(depth[seen] - expected_m) * np.sqrt(root[seen]) / RADIUS_M
    assert met.mean() > 0.995
    assert 1e-9 < off_along_normal_m[met].max() < 3e-6
    assert depth[HEIGHT // 2, WIDTH // 2] == pytest.approx(STANDOFF_M - RADIUS_M, abs=2e-5)


def test_the_lamps_light_the_cable_evenly_and_without_render_noise(traced):
    _, light, depth = traced
    row = light[HEIGHT // 2, 20:140, 1]
    assert 0.1 < row.min() < row.max() < 0.9
    assert np.abs(np.diff(row, 2)).max() < 0.001 * row.mean()
    assert np.all(light[depth == 0.0] < 0.9)


def test_a_picture_that_did_not_go_through_the_lens_is_an_error(tmp_path):
    spec = survey(-0.02)
    built = build_scene(spec, None)
    built.camera.data.type = "PERSP"
    built.camera.data.sensor_width, built.camera.data.lens = WIDTH, FOCAL  # even the right pinhole is refused
    with pytest.raises(StageError, match="was not traced through the division lens"):
        trace(built, moment(spec), tmp_path)


def test_a_lens_parameter_that_did_not_arrive_is_an_error(tmp_path):
    spec = survey(-0.02)
    built = build_scene(spec, None)
    light, _ = trace(built, moment(spec), tmp_path)
    assert light.shape == (HEIGHT, WIDTH, 3)
    told, (poses,) = block_lenses(survey(-0.03))[0], block_poses(spec)
    v, u = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    hits = np.stack([u, v, np.ones_like(u)], axis=-1)
    with pytest.raises(StageError, match="lens"):
        check_rays(told, poses.rotations[0], poses.translations[0], hits, "Block1 frame 0")


def test_an_empty_view_is_an_error(tmp_path):
    spec = survey(-0.02)
    turned = moment(spec)
    half_turn = np.diag([1.0, -1.0, -1.0])
    away = Moment(
        **{
            **vars(turned),
            "rotation": half_turn @ turned.rotation,
            "translation": half_turn @ turned.translation,
        }
    )
    with pytest.raises(StageError, match="shows no cable"):
        trace(build_scene(spec, None), away, tmp_path)


def test_control_c_during_a_render_is_not_lost(tmp_path):
    spec = replace(survey(-0.02), sensor=Sensor(samples=150))
    built = build_scene(spec, None)
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        trace(built, moment(spec), tmp_path)


def test_a_swaying_camera_still_meets_its_true_rays(tmp_path):
    spec = survey(-0.1, sway_deg=3.0, sway_mm=5.0, mounting_deg=2.0)
    _, depth = trace(build_scene(spec, None), moment(spec, frame=1), tmp_path)  # trace checks the rays itself
    assert 0.3 < np.mean(depth > 0.0) < 0.6
