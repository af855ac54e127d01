"""Bias, noise, holes and made-up parts of the radius map are found as they were put in."""

import numpy as np
import pytest

from pipeline.evaluate import evaluate
from tests.evaluate.written_run import TRAVEL_M, true_radius


def test_bias_and_noise_of_the_surface_are_found_as_put_in(case):
    def noisy(theta, position):
        shape = (len(position), len(theta))
        noise = np.random.default_rng(4).normal(0, 0.03, shape)
        noise[5, ::7] = 3.0  # a few wild cells do not count as noise
        low = 0.2 * np.cos(2 * np.radians(theta)) * np.linspace(-1, 1, shape[0])[:, None]
        return true_radius(theta, position) + 0.05 + noise + low

    found = evaluate(*case(radius_mm=noisy)).surface
    assert found.bias_mm == pytest.approx(0.05, abs=0.01)
    assert 0.028 < found.noise_mm < 0.032
    assert 0.15 < found.within_95_mm < 0.35


def about_bowed_axis(theta, position, rise_mm):
    """Radii about the y axis of the true surface moved by an axis that bows towards azimuth 90 degrees,
    -z."""
    offset = rise_mm * 4 * (position / TRAVEL_M) * (1 - position / TRAVEL_M)
    rows = []
    for y, e in zip(position, offset, strict=True):
        a = np.radians(np.arange(0.0, 360.0, 0.25))  # about the bowed axis, then seen from the y axis
        r = true_radius(np.degrees(a), [y])[0]
        x, z = r * np.cos(a), -r * np.sin(a) - e
        seen, order = np.degrees(np.arctan2(-z, x)) % 360, None
        order = np.argsort(seen)
        rows.append(np.interp(theta, seen[order], np.hypot(x, z)[order], period=360))
    return np.array(rows)


def test_a_map_about_a_straight_axis_agrees_with_a_truth_about_a_bowed_one(case):
    found = evaluate(*case(radius_mm=lambda t, p: about_bowed_axis(t, p, 3.0))).surface
    assert abs(found.bias_mm) < 2e-3  # a first harmonic alone would leave up to e^2 / 4 r = 0.04 mm
    assert found.within_95_mm < 4e-3
    assert found.wrong_percent == 0


def test_a_ring_out_of_the_middle_is_no_error_of_the_surface_and_an_oval_one_is(case):
    def shifted(theta, position):
        return true_radius(theta, position) + 0.4 * np.cos(np.radians(theta - 40))

    def oval(theta, position):
        return true_radius(theta, position) + 0.4 * np.cos(2 * np.radians(theta - 40))

    assert evaluate(*case(radius_mm=shifted)).surface.within_95_mm < 6e-3
    assert 0.39 < evaluate(*case(radius_mm=oval)).surface.within_95_mm < 0.41


def test_holes_lower_the_coverage_and_an_open_ring_is_compared_as_it_stands(case):
    def strip(theta, position):
        radius = true_radius(theta, position) + 0.1 * np.cos(np.radians(theta))
        radius[:, theta > 120] = np.nan
        return radius

    found = evaluate(*case(radius_mm=strip)).surface
    assert found.coverage_percent == pytest.approx(100 / 3, abs=0.2)
    assert 0.09 < found.within_95_mm < 0.11


def test_what_is_told_as_seen_and_is_not_right_is_overclaimed(case):
    def guessed(theta, position):
        radius = true_radius(theta, position)
        radius[:, (theta > 90) & (theta < 180)] += 1.0  # a quarter is made up
        radius[:, (theta > 300) & (theta < 330)] = np.nan
        return radius

    found = evaluate(*case(radius_mm=guessed)).surface
    assert found.wrong_percent == pytest.approx(100 * 90 / 330, abs=0.5)
    for station in found.stations:
        assert station.right_deg == pytest.approx(240, abs=3)
        assert station.overclaimed_deg == pytest.approx(110, abs=3)
