"""Cylinder, sphere and similarity fits."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.fits import FitOptions, Loss, fit_cylinder, fit_similarity, fit_sphere
from pipeline.core.rotations import rotation_from_vector

AXIS = np.array([0.1, 0.97, -0.2]) / np.linalg.norm([0.1, 0.97, -0.2])
POINT = np.array([0.02, 0.3, -0.01])


def cylinder_points(rng, *, count=2000, span_deg=120.0, radius=0.055, noise=0.0, bow=0.0, length=0.46):
    """Points on part of a cylinder of the given length about POINT and AXIS; bow in 1/m, towards u."""
    u = np.cross(AXIS, [0, 0, 1.0])
    u /= np.linalg.norm(u)
    v = np.cross(AXIS, u)
    t = rng.uniform(-length / 2, length / 2, count)
    a = np.radians(rng.uniform(-span_deg / 2, span_deg / 2, count))
    rho = radius + noise * rng.normal(size=count)
    across = (rho * np.cos(a))[:, None] * u + (rho * np.sin(a))[:, None] * v
    return POINT + t[:, None] * AXIS + bow * (t**2)[:, None] * u + across, u


@pytest.mark.parametrize("span_deg", [70.0, 120.0, 360.0])
def test_clean_cylinder_is_exact_without_a_hint(span_deg):
    points, _ = cylinder_points(np.random.default_rng(0), span_deg=span_deg)
    cylinder = fit_cylinder(points)
    assert cylinder.radius == pytest.approx(0.055, abs=1e-10)
    np.testing.assert_allclose(cylinder.direction, AXIS, atol=1e-8)
    np.testing.assert_allclose(np.cross(cylinder.point - POINT, AXIS), 0, atol=1e-10)
    np.testing.assert_allclose(cylinder.distances(points), 0, atol=1e-9)


def test_short_ring_is_not_mistaken_for_a_long_axis():
    points, _ = cylinder_points(np.random.default_rng(1), span_deg=360, length=0.03)
    np.testing.assert_allclose(fit_cylinder(points).direction, AXIS, atol=1e-7)


def test_cylinder_sigma_equals_scatter_and_radius_is_unbiased():
    rng = np.random.default_rng(2)
    fits = [fit_cylinder(cylinder_points(rng, count=600, noise=5e-4)[0], direction=AXIS) for _ in range(200)]
    errors = np.array([fit.radius for fit in fits]) - 0.055
    assert abs(np.mean(errors)) < 3 * np.std(errors) / np.sqrt(200)
    assert np.mean([fit.radius_sigma for fit in fits]) == pytest.approx(np.std(errors), rel=0.15)
    assert np.mean([fit.noise_sigma for fit in fits]) == pytest.approx(5e-4, rel=0.05)


def test_cylinder_ignores_a_fifth_of_gross_errors():
    rng = np.random.default_rng(3)
    points, _ = cylinder_points(rng, noise=1e-4)
    points[:400] += rng.uniform(-0.03, 0.05, (400, 3))
    assert fit_cylinder(points).radius == pytest.approx(0.055, abs=4e-5)


def test_bowed_axis_is_followed():
    """2 mm of sag over 0.46 m: a straight cylinder is off, a bowed one is not."""
    rng = np.random.default_rng(4)
    points, u = cylinder_points(rng, noise=5e-5, bow=0.002 / 0.23**2)
    bowed = fit_cylinder(points, bowed=True)
    assert bowed.radius == pytest.approx(0.055, abs=2e-5)
    assert bowed.bow @ u == pytest.approx(0.002 / 0.23**2, rel=0.02)
    assert bowed.noise_sigma < 6e-5
    assert fit_cylinder(points).noise_sigma > 3e-4
    end = bowed.axis_at([0.23])[0] - bowed.point
    assert end @ u == pytest.approx(0.002, abs=2e-4)
    assert np.median(np.abs(bowed.distances(points))) < 5e-5


def test_too_few_points_for_a_cylinder_are_refused():
    with pytest.raises(StageError, match="at least 5"):
        fit_cylinder(np.eye(3))


def test_sphere_cap_free_and_with_known_radius():
    rng = np.random.default_rng(5)
    directions = rng.normal((0, 0, 2.5), 1, size=(800, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = np.array([1.0, 2.0, 3.0]) + 0.0725 * directions + 2e-4 * rng.normal(size=(800, 3))
    free, held = fit_sphere(points), fit_sphere(points, radius=0.0725)
    for sphere in (free, held):
        sigmas = np.sqrt(np.diag(sphere.covariance)[:3])
        assert (np.abs(sphere.centre - [1, 2, 3]) < 4 * sigmas).all()
    assert abs(free.radius - 0.0725) < 4 * free.radius_sigma
    assert held.radius_sigma == 0
    assert held.covariance[2, 2] < free.covariance[2, 2]
    with pytest.raises(StageError, match="plane"):
        fit_sphere(np.column_stack([rng.normal(size=(9, 2)), np.zeros(9)]))


def test_similarity_is_recovered_exactly_and_the_rigid_one_keeps_scale_one():
    rng = np.random.default_rng(6)
    source = rng.normal(size=(12, 3))
    R = rotation_from_vector(np.array([0.4, -1.1, 2.0]))
    moved = fit_similarity(source, 1.7 * source @ R.T + [1, 2, 3])
    assert moved.scale == pytest.approx(1.7, abs=1e-12)
    np.testing.assert_allclose(moved.rotation, R, atol=1e-12)
    np.testing.assert_allclose(moved.apply(source), 1.7 * source @ R.T + [1, 2, 3], atol=1e-12)
    rigid = fit_similarity(source, source @ R.T + [1, 2, 3], with_scale=False)
    assert rigid.scale == 1
    np.testing.assert_allclose(rigid.translation, [1, 2, 3], atol=1e-12)


def test_similarity_never_reflects():
    source = np.random.default_rng(7).normal(size=(12, 3))
    assert np.linalg.det(fit_similarity(source, source * [1, 1, -1]).rotation) == pytest.approx(1)


def test_similarity_weights_and_covariance():
    rng = np.random.default_rng(8)
    source = rng.normal(size=(20, 3))
    scales = []
    for _ in range(100):
        found = fit_similarity(source, 2 * source + 0.01 * rng.normal(size=(20, 3)))
        scales.append(found.scale)
    assert np.sqrt(found.covariance[6, 6]) == pytest.approx(np.std(scales), rel=0.4)
    target = source.copy()
    target[0] += 5
    weights = np.ones(20)
    weights[0] = 0
    np.testing.assert_allclose(fit_similarity(source, target, weights).translation, 0, atol=1e-12)
    with pytest.raises(StageError, match="line"):
        fit_similarity(np.outer(np.arange(5.0), [1, 1, 1]), np.outer(np.arange(5.0), [1, 0, 1]))


def test_least_squares_is_used_when_asked():
    points, _ = cylinder_points(np.random.default_rng(9), count=500, noise=1e-4)
    cylinder = fit_cylinder(points, options=FitOptions(loss=Loss.LEAST_SQUARES))
    np.testing.assert_array_equal(cylinder.robust_weights, 1)
