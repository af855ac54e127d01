"""Unrolled coordinates about a straight or bowed axis go there and back, and mean what the contract says."""

import numpy as np

from pipeline.core.axis import AxisCurve, axis_of_cylinder
from pipeline.core.fits.cylinder import fit_cylinder

BOWED = AxisCurve(origin_y_m=0.2, coefficients=np.array([[0.001, 0.02, 0.05], [-0.002, -0.01, 0.03]]))


def places(count=200, seed=2):
    rng = np.random.default_rng(seed)
    return rng.uniform(-np.pi, np.pi, count), rng.uniform(0, 0.5, count), rng.uniform(0.04, 0.07, count)


def test_the_axis_is_the_polynomial_in_y():
    at = BOWED.at(np.array([0.2, 0.3]))
    np.testing.assert_allclose(at[0], [0.001, 0.2, -0.002])
    np.testing.assert_allclose(at[1], [0.001 + 0.002 + 0.0005, 0.3, -0.002 - 0.001 + 0.0003])


def test_azimuth_turns_by_the_right_hand_rule_about_y():
    straight = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 2)))
    points = straight.roll(np.array([0, np.pi / 2, np.pi]), np.array([0.1, 0.2, 0.3]), np.full(3, 0.05))
    np.testing.assert_allclose(points, [[0.05, 0.1, 0], [0, 0.2, -0.05], [-0.05, 0.3, 0]], atol=1e-16)


def test_rolling_undoes_unrolling():
    azimuth, y_m, radius = places()
    found = BOWED.unroll(BOWED.roll(azimuth, y_m, radius))
    for got, put in zip(found, (azimuth, y_m, radius), strict=True):
        np.testing.assert_allclose(got, put, atol=1e-13)


def test_a_grid_rolls_as_its_points_do_one_by_one():
    azimuth, y_m = np.linspace(-2.0, 2.5, 7), np.linspace(0.1, 0.4, 5)
    radius = 0.055 + 0.001 * np.random.default_rng(4).random((5, 7))
    turn, along = np.meshgrid(azimuth, y_m)
    one_by_one = BOWED.roll(turn.ravel(), along.ravel(), radius.ravel()).reshape(5, 7, 3)
    np.testing.assert_allclose(BOWED.roll_grid(azimuth, y_m, radius), one_by_one, atol=1e-15)


def test_the_axis_of_a_fitted_cylinder_lies_on_the_cylinder_s_own():
    azimuth, y_m, _ = places(2000)
    tilted = AxisCurve(origin_y_m=0.25, coefficients=np.array([[0.002, 0.03, 0.0], [-0.001, -0.02, 0.0]]))
    # about a tilted axis a circle square to it is an ellipse in the plane of constant y
    slope = np.array([0.03, -0.02])
    along = (np.cos(azimuth) * slope[0] - np.sin(azimuth) * slope[1]) / np.sqrt(1 + slope @ slope)
    points = tilted.roll(azimuth, y_m, 0.055 / np.sqrt(1 - along**2))
    found = axis_of_cylinder(fit_cylinder(points, direction=(0, 1, 0)))
    y = np.linspace(0, 0.5, 7)
    np.testing.assert_allclose(found.at(y), tilted.at(y), atol=1e-9)


def test_a_bowed_cylinder_keeps_its_bow():
    azimuth, y_m, _ = places(4000)
    bowed = AxisCurve(origin_y_m=0.25, coefficients=np.array([[0.0, 0.0, 0.02], [0.0, 0.0, -0.01]]))
    found = axis_of_cylinder(
        fit_cylinder(bowed.roll(azimuth, y_m, np.full(4000, 0.055)), direction=(0, 1, 0), bowed=True)
    )
    y = np.linspace(0.02, 0.48, 7)
    # sagitta 1.4 mm; sections of constant y are no exact sections of a bowed cylinder
    np.testing.assert_allclose(found.at(y), bowed.at(y), atol=1e-5)
