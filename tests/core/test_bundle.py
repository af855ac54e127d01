"""The adjustment finds what was put in, weighs priors as stated, and its covariance means what it says."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.bundle import BundleOptions, RigPriors, adjust_bundle, intersect_points
from pipeline.core.division import project_with_jacobian
from pipeline.core.rig import Observations, Rig, linearise, points_in_camera
from pipeline.core.rotations import nominal_cam_from_world, rotation_from_vector
from pipeline.core.vocabulary import TravelDirection

LENS = np.array([720.0, 480.0, 300.0, -0.0625])


def ring(frames=8, cameras=4, points=600, seed=1):
    """A rig of cameras 0.3 m off the axis, and points on a 110 mm cable that the cameras really see."""
    rng = np.random.default_rng(seed)
    azimuths = 360.0 * np.arange(cameras) / cameras
    theta, y = rng.uniform(0, 2 * np.pi, points), np.sort(rng.uniform(-0.05, 0.25, points))
    mounts = np.stack([nominal_cam_from_world(a, TravelDirection.RIGHT) for a in azimuths])
    radians = np.deg2rad(azimuths)
    rig = Rig(
        body_rotations=np.tile(np.eye(3), (frames, 1, 1)),
        body_centres=np.stack([np.zeros(frames), np.linspace(0, 0.2, frames), np.zeros(frames)], axis=1),
        mount_rotations=mounts,
        mount_centres=0.3 * np.stack([np.cos(radians), 0 * radians, -np.sin(radians)], axis=1),
        lenses=np.tile(LENS, (cameras, 1)),
        points=np.stack([0.055 * np.cos(theta), y, -0.055 * np.sin(theta)], axis=1),
    )
    facing = np.cos(theta[:, None] - radians) > np.cos(np.deg2rad(60))
    camera, frame, point = np.meshgrid(
        np.arange(cameras), np.arange(frames), np.arange(points), indexing="ij"
    )
    keep = facing[point, camera] & (np.abs(rig.body_centres[frame, 1] - y[point]) < 0.12)
    seen = Observations(
        frame=frame[keep], camera=camera[keep], point=point[keep], pixels=np.zeros((keep.sum(), 2))
    )
    return rig, observe(rig, seen)


def observe(rig, observations, sigma_px=0.0, seed=0):
    _, in_camera = points_in_camera(rig, observations)
    pixels, _, _ = project_with_jacobian(rig.lenses[observations.camera], in_camera)
    noise = np.random.default_rng(seed).normal(0, sigma_px, pixels.shape) if sigma_px else 0
    return replace(observations, pixels=pixels + noise)


def sway(rig, turn_deg, shift_m, seed=3):
    rng = np.random.default_rng(seed)
    turn = rotation_from_vector(np.deg2rad(rng.normal(0, turn_deg, (len(rig.body_centres), 3))))
    return replace(
        rig,
        body_rotations=turn @ rig.body_rotations,
        body_centres=rig.body_centres + rng.normal(0, shift_m, rig.body_centres.shape),
    )


def priors_for(rig, turn_deg=0.3, shift_m=1e-3, mount=0.0, lens=0.0):
    frames, cameras = len(rig.body_rotations), len(rig.mount_rotations)
    body = np.tile([np.deg2rad(turn_deg)] * 3 + [shift_m] * 3, (frames, 1))
    body[[0, -1]] = 1e-9
    return RigPriors(
        reference=rig,
        body_sigmas=body,
        mount_sigmas=np.full((cameras, 6), mount),
        lens_sigmas=np.full((cameras, 4), lens),
    )


def quiet(iteration, iterations):
    pass


def test_derivatives_agree_with_central_differences():
    rig, seen = ring(frames=3, points=60)
    rig = replace(sway(rig, 0.5, 1e-3), readout_m=2e-3)
    seen = replace(seen, moment=seen.pixels[:, 1] / 600 - 0.5)
    state = linearise(rig, seen)
    rng = np.random.default_rng(0)
    step = rng.normal(0, 1e-6, rig.unknowns)
    point_step = rng.normal(0, 1e-7, rig.points.shape)
    forward = linearise(rig.moved(step, point_step), seen).residuals
    backward = linearise(rig.moved(-step, -point_step), seen).residuals
    predicted = np.einsum("jin,nj->ni", state.orientation, step[state.columns[state.image]])
    predicted += np.einsum("jin,nj->ni", state.points, point_step[seen.point])
    np.testing.assert_allclose((backward - forward) / 2, predicted, atol=2e-8)


def test_a_swaying_rig_is_found_again_without_noise():
    nominal, seen = ring()
    truth = sway(nominal, 0.3, 1e-3)
    truth = replace(
        truth,
        body_rotations=np.concatenate(
            [nominal.body_rotations[:1], truth.body_rotations[1:-1], nominal.body_rotations[-1:]]
        ),
        body_centres=np.concatenate(
            [nominal.body_centres[:1], truth.body_centres[1:-1], nominal.body_centres[-1:]]
        ),
    )
    measured = observe(truth, seen)
    priors = priors_for(nominal, turn_deg=30, shift_m=1.0)
    result = adjust_bundle(nominal, measured, priors, BundleOptions(), quiet)
    assert np.abs(result.rig.body_centres - truth.body_centres).max() < 2e-6
    assert np.abs(result.rig.points - truth.points).max() < 5e-6
    assert np.abs(result.residuals).max() < 1e-3


def test_the_closed_ring_sees_the_focal_length_that_a_strip_cannot():
    """Design fact 2: depth for one camera is width for its neighbour."""
    nominal, seen = ring()
    truth = sway(nominal, 0.3, 5e-4)
    truth = replace(truth, body_centres=np.vstack([nominal.body_centres[:1], truth.body_centres[1:]]))
    truth.body_centres[-1] = nominal.body_centres[-1]
    measured = observe(truth, seen, sigma_px=0.05)
    wrong = replace(nominal, lenses=nominal.lenses * np.array([1.05, 1, 1, 1]))
    priors = priors_for(wrong, turn_deg=0.5, shift_m=1e-3)
    lens = np.zeros((4, 4))
    lens[:, 0] = np.inf
    priors = replace(priors, lens_sigmas=lens)
    options = BundleOptions(sigma_px=0.05, iterations=60, tolerance=1e-9)
    result = adjust_bundle(wrong, measured, priors, options, quiet)
    assert np.abs(result.rig.lenses[:, 0] / 720 - 1).max() < 0.005


def test_gross_errors_lose_their_weight():
    nominal, seen = ring()
    measured = observe(nominal, seen, sigma_px=0.05)
    bad = np.random.default_rng(5).random(len(measured)) < 0.05
    pixels = measured.pixels.copy()
    pixels[bad] += 20
    result = adjust_bundle(
        nominal, replace(measured, pixels=pixels), priors_for(nominal), BundleOptions(), quiet
    )
    assert result.weights[bad].max() < 0.05
    assert np.median(result.weights[~bad]) > 0.9
    assert np.abs(result.rig.body_centres - nominal.body_centres).max() < 1e-4


@pytest.mark.parametrize("sigma_px", [0.1, 0.3])
def test_covariance_predicts_the_scatter_of_repeated_surveys(sigma_px):
    nominal, seen = ring(frames=4, points=300)
    priors = priors_for(nominal, turn_deg=5, shift_m=0.1)
    options = BundleOptions(sigma_px=sigma_px, loss_scale_px=100)
    centres, predicted = [], None
    for seed in range(25):
        result = adjust_bundle(nominal, observe(nominal, seen, sigma_px, seed), priors, options, quiet)
        centres.append(result.rig.body_centres[2])
        predicted = np.sqrt(np.diag(result.covariance)[6 * 2 + 3 : 6 * 2 + 6])
    ratio = np.std(centres, axis=0) / predicted
    assert np.all((ratio > 0.6) & (ratio < 1.5))


@pytest.mark.parametrize("readout_m", [4e-3, -1e-3, 0.0])
def test_points_that_neighbours_share_tell_how_a_rolling_shutter_reads(readout_m):
    """Rows of one frame show different moments: up to 4 mm of travel between the first and the last."""
    nominal, seen = ring(points=1500)
    centres = sway(nominal, 0.0, 5e-4).body_centres
    centres[[0, -1]] = nominal.body_centres[[0, -1]]
    truth = replace(nominal, body_centres=centres, readout_m=readout_m)
    moment = observe(truth, seen).pixels[:, 1] / 600 - 0.5
    measured = observe(truth, replace(seen, moment=moment), sigma_px=0.1)
    priors = replace(priors_for(nominal), readout_sigma_m=5e-3)
    result = adjust_bundle(nominal, measured, priors, BundleOptions(sigma_px=0.1), quiet)
    sigma_m = np.sqrt(result.covariance[-1, -1])
    assert 1e-6 < sigma_m < 1e-4
    assert abs(result.rig.readout_m - readout_m) < 3.5 * sigma_m
    assert np.abs(result.rig.points - truth.points).mean() < 2e-4


def test_a_single_camera_cannot_tell_a_rolling_shutter_from_a_sheared_surface():
    nominal, seen = ring(cameras=1)
    moment = seen.pixels[:, 1] / 600 - 0.5
    measured = observe(replace(nominal, readout_m=4e-3), replace(seen, moment=moment), sigma_px=0.1)
    priors = replace(priors_for(nominal, turn_deg=0.3), readout_sigma_m=5e-3)
    result = adjust_bundle(nominal, measured, priors, BundleOptions(sigma_px=0.1), quiet)
    assert np.sqrt(result.covariance[-1, -1]) > 0.5 * 5e-3


@pytest.mark.parametrize("gross_errors", [True, False])
def test_points_are_intersected_to_the_end_from_millimetres_away(gross_errors):
    truth, seen = ring(points=200)
    astray = replace(truth, points=truth.points + np.random.default_rng(2).normal(0, 2e-3, (200, 3)))
    found, residuals = intersect_points(astray, seen, gross_errors=gross_errors)
    tied = np.bincount(seen.point, minlength=200) >= 2
    assert np.abs(found.points - truth.points)[tied].max() < 1e-7
    assert np.abs(residuals).max() < 1e-3


def test_held_values_do_not_move():
    nominal, seen = ring(frames=4, points=200)
    truth = sway(nominal, 0.2, 5e-4)
    result = adjust_bundle(nominal, observe(truth, seen), priors_for(nominal), BundleOptions(), quiet)
    np.testing.assert_array_equal(result.rig.mount_centres, nominal.mount_centres)
    np.testing.assert_array_equal(result.rig.lenses, nominal.lenses)
