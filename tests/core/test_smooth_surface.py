"""A smooth surface of no stated size: it follows what is there, forgets what stands out, and stays weak."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.bundle import BundleOptions, adjust_bundle
from pipeline.core.normals import PointEquations, assemble, solve, split_along_cable, with_point_equations
from pipeline.core.rig import linearise
from pipeline.core.smooth_surface import SmoothSurface, surface_prior
from tests.core.test_bundle import observe, priors_for, quiet, ring, sway

LENGTH_M = 0.4


def cable(count=4000, seed=0, radius_m=lambda azimuth, y: 0.055, noise_m=0.0):
    """Points of a cable that bows by 2 mm about x and leans by 1 mm about z."""
    rng = np.random.default_rng(seed)
    azimuth, y = rng.uniform(-np.pi, np.pi, count), np.sort(rng.uniform(0, LENGTH_M, count))
    radius = radius_m(azimuth, y) + rng.normal(0, noise_m, count)
    bow = 0.002 * (1 - (2 * y / LENGTH_M - 1) ** 2)
    lean = 0.001 * y / LENGTH_M
    return np.stack([bow + radius * np.cos(azimuth), y, lean - radius * np.sin(azimuth)], axis=1), azimuth


def prior(points, sigma_m=2e-4):
    return surface_prior(points, sigma_m, sigma_m, 0.02)


def distances_mm(found, points):
    return 1000 * found.surface.distances(points)[0]


def test_derivatives_agree_with_central_differences():
    rng = np.random.default_rng(1)
    points, _ = cable(50)
    points += rng.normal(0, 1e-3, points.shape)
    nodes = np.linspace(0, LENGTH_M, 7)
    values = np.array([1e-3, 2e-3, -1e-3, 5e-4, -2e-3, 1e-3, 3e-4, -4e-4, *[0.055] * 7, 8e-4, -5e-4])
    values[8:15] += rng.normal(0, 5e-4, 7)
    surface = SmoothSurface(nodes_y_m=nodes, values=values)
    _, by_point, by_values = surface.distances(points)
    step, point_step = rng.normal(0, 1e-6, len(values)), rng.normal(0, 1e-6, points.shape)
    forward = surface.moved(step).distances(points + point_step)[0]
    backward = surface.moved(-step).distances(points - point_step)[0]
    predicted = by_values @ step + np.sum(by_point * point_step, axis=1)
    np.testing.assert_allclose((forward - backward) / 2, predicted, atol=1e-10)
    assert np.abs(predicted).max() > 1e-7


def test_a_bowed_cable_lies_on_its_surface():
    points, _ = cable()
    found = prior(points)
    assert np.abs(distances_mm(found, points)).max() < 1e-3
    middle = found.surface.axis.at(np.array([0.0, LENGTH_M / 2, LENGTH_M]))
    np.testing.assert_allclose(1000 * middle[:, 0], [0, 2, 0], atol=2e-3)
    np.testing.assert_allclose(1000 * middle[:, 2], [0, 0.5, 1], atol=2e-3)


def test_the_radius_is_free_at_every_place():
    """One millimetre of difference within 0.1 m is no departure from the surface."""
    points, _ = cable(radius_m=lambda _, y: 0.055 + 0.001 * np.clip((y - 0.15) / 0.1, 0, 1))
    found = prior(points)
    assert np.abs(distances_mm(found, points)).max() < 0.06
    assert np.ptp(1000 * found.surface.radii_m) == pytest.approx(1.0, abs=0.06)


def test_an_oval_cable_is_no_departure():
    points, _ = cable(radius_m=lambda a, _: 0.055 + 4e-4 * np.cos(2 * (a - 0.3)))
    found = prior(points)
    assert np.abs(distances_mm(found, points)).max() < 0.01
    np.testing.assert_allclose(
        1000 * found.surface.values[-2:], 0.4 * np.array([np.cos(0.6), np.sin(0.6)]), atol=5e-3
    )


def test_no_size_is_cheaper_than_another():
    """The prior knows no diameter: a cable a fifth wider costs the same."""
    narrow, _ = cable(noise_m=1e-4)
    wide, _ = cable(radius_m=lambda a, y: 0.066, noise_m=1e-4)
    costs = [replace(prior(p), sigmas_m=np.full(len(p), 1e-3)).cost(p) for p in (narrow, wide)]
    assert costs[1] == pytest.approx(costs[0], rel=0.05)
    assert costs[0] > 0


def test_a_fillet_of_two_millimetres_loses_its_weight_and_does_not_move_the_surface():
    def radius(azimuth, y):
        turn = np.angle(np.exp(1j * (azimuth - 2 * np.pi * y / 0.25)))
        return 0.055 + 0.002 * (np.abs(turn) < 0.15)

    points, azimuth = cable(radius_m=radius, noise_m=5e-5)
    found = prior(points)
    high = radius(azimuth, points[:, 1]) > 0.056
    weights = found.weights(distances_mm(found, points) / 1000) * found.sigmas_m**2
    assert 0.03 < high.mean() < 0.08
    assert weights[high].max() < 0.02
    assert np.median(weights[~high]) > 0.9
    assert np.abs(1000 * found.surface.radii_m - 55).max() < 0.03


def test_more_points_in_a_patch_are_no_more_evidence():
    few, many = (cable(count, noise_m=5e-5)[0] for count in (4000, 16000))
    told = [np.sum(1 / prior(p).sigmas_m ** 2) for p in (few, many)]
    assert told[1] == pytest.approx(told[0], rel=0.05)
    patches = LENGTH_M * 2 * np.pi * 0.055 / 0.02**2
    assert told[0] * 2e-4**2 == pytest.approx(patches, rel=0.1)


def test_the_step_is_that_of_all_equations_solved_at_once():
    """The Schur complement over the points against a plain least squares solution of the whole system."""
    rig, seen = ring(frames=6, cameras=2, points=40)
    rig = sway(rig, 0.1, 3e-4)
    state, priors = linearise(rig, seen), priors_for(rig, lens=0.0)
    rng = np.random.default_rng(4)
    said = PointEquations(
        residuals=rng.normal(size=40),
        points=1e3 * rng.normal(size=(40, 3)),
        shared=rng.normal(size=(40, 5)),
        information=np.eye(5),
        right=rng.normal(size=5),
    )
    sigmas = priors.sigmas
    normals = assemble(
        state, np.ones(len(seen)), 0 * sigmas, sigmas, split_along_cable(seen, len(rig.points))
    )
    step, point_steps = solve(with_point_equations(normals, said), 0.0)
    own, places = len(sigmas), len(sigmas) + 5
    rows = np.zeros((2 * len(seen) + 40 + 5 + own, places + 120))
    images = rows[: 2 * len(seen)].reshape(len(seen), 2, -1)
    for n in range(len(seen)):
        images[n][:, state.columns[state.image[n]]] += state.orientation[:, :, n].T
        first = places + 3 * seen.point[n]
        images[n][:, first : first + 3] += state.points[:, :, n].T
    for m in range(40):
        rows[2 * len(seen) + m, own:places] = said.shared[m]
        rows[2 * len(seen) + m, places + 3 * m : places + 3 * m + 3] = said.points[m]
    rows[2 * len(seen) + 40 : 2 * len(seen) + 45, own:places] = np.eye(5)
    held = sigmas == 0
    rows[2 * len(seen) + 45 :, :own] = np.diag(np.where(held, 0, 1 / np.where(held, 1, sigmas)))
    right = np.concatenate([state.residuals.ravel(), said.residuals, said.right, np.zeros(own)])
    rows[:, :own][:, held] = 0
    scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-12)
    direct = np.linalg.lstsq(rows / scale, right, rcond=1e-13)[0] / scale
    direct[:own][held] = 0
    np.testing.assert_allclose(step, direct[:places], rtol=1e-4, atol=1e-9)
    seen_well = np.bincount(seen.point, minlength=40) >= 3
    assert seen_well.sum() > 10
    direct_points = direct[places:].reshape(-1, 3)
    np.testing.assert_allclose(point_steps[seen_well], direct_points[seen_well], rtol=1e-3, atol=1e-7)


def test_the_prior_tells_of_the_orientations_and_never_makes_them_less_sure():
    nominal, seen = ring(frames=4, points=400)
    truth = sway(nominal, 0.1, 3e-4)
    measured, priors = observe(truth, seen, 0.3), priors_for(nominal, mount=1e-3)
    priors = replace(priors, lens_sigmas=np.tile([30.0, 0, 0, 0], (4, 1)))
    options = BundleOptions(sigma_px=0.3, loss_scale_px=100, tolerance=1e-9)
    free = adjust_bundle(nominal, measured, priors, options, quiet)
    tied = adjust_bundle(free.rig, measured, priors, options, quiet, prior(free.rig.points, 5e-5))
    loose = adjust_bundle(free.rig, measured, priors, options, quiet, prior(free.rig.points, 1.0))
    before, after, barely = (np.diag(r.covariance) for r in (free, tied, loose))
    assert tied.covariance.shape == free.covariance.shape
    assert (after <= before * 1.01).all()
    focal = np.arange(nominal.unknowns)[nominal.lens_unknowns][::4]
    assert (after[focal] < 0.8 * before[focal]).all()
    np.testing.assert_allclose(barely, before, rtol=1e-3)
    spread = [np.abs(r.surface.surface.distances(r.rig.points)[0]).mean() for r in (tied, loose)]
    assert spread[0] < 0.9 * spread[1]
