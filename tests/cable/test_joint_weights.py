"""A measurement is believed as far as its like have fitted: by camera, and by direction of the image."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cable.joint_weights import weighed
from pipeline.core.rig import Observations

POINTS, VIEWS, SIGMA_PX, LEAST_PX = 400, 10, 0.1, 0.05


def measured(looseness=None, shared=0):
    """Two cameras, each with points seen in ten frames, then marks seen by both in as many."""
    point = np.repeat(np.arange(2 * POINTS), VIEWS)
    mark = np.repeat(2 * POINTS + np.arange(shared), 2 * VIEWS)
    count = len(point) + len(mark)
    return Observations(
        frame=np.arange(count) % VIEWS,
        camera=np.concatenate([point // POINTS, np.arange(len(mark)) // VIEWS % 2]),
        point=np.concatenate([point, mark]),
        pixels=np.random.default_rng(7).uniform([0, 0], [960, 600], (count, 2)),
        looseness=looseness,
    )


def result(residuals_px, shared=0):
    """As from an adjustment; the marks lie 50 mm apart."""
    points = np.zeros((2 * POINTS + shared, 3))
    points[2 * POINTS :, 1] = 0.05 * np.arange(shared)
    return SimpleNamespace(residuals=residuals_px, rig=SimpleNamespace(points=points))


def residuals(sigmas_px, shared=0, shared_px=0.3, seed=1):
    rng = np.random.default_rng(seed)
    parts = [rng.normal(0, s, (POINTS * VIEWS, 2)) for s in sigmas_px]
    # a mark's measurements by one camera all share one error
    marks = np.repeat(rng.normal(0, shared_px, (2 * shared, 2)), VIEWS, axis=0)
    return np.concatenate([*parts, marks])


TIED = 2 * POINTS * VIEWS
REDUNDANCY = 1 - 3 / (2 * VIEWS)
"""Three unknowns a point against two residuals a view."""


def test_each_camera_and_direction_gets_the_spread_of_its_own_residuals():
    fit = result(residuals([(0.3, 0.08), (0.2, 0.2)]))
    found = weighed(measured(), fit, TIED, SIGMA_PX, LEAST_PX)
    expected = np.array([(0.3, 0.08), (0.2, 0.2)]) / np.sqrt(REDUNDANCY) / SIGMA_PX
    np.testing.assert_allclose(found.looseness[0], expected[0], rtol=0.08)
    np.testing.assert_allclose(found.looseness[-1], expected[1], rtol=0.08)


def test_points_matched_on_the_same_texture_count_as_one():
    """Four points at one place of every frame that err alike, in one of the two directions."""
    views = measured()
    fit = residuals([(0.2, 0.2), (0.2, 0.2)])
    pixels = views.pixels.copy()
    errors = fit[: POINTS * VIEWS].reshape(POINTS // 4, 4, VIEWS, 2)
    errors[..., 0] = errors[:, :1, :, 0]
    places = pixels[: POINTS * VIEWS].reshape(POINTS // 4, 4, VIEWS, 2)
    places[:] = places[:, :1]
    found = weighed(replace(views, pixels=pixels), result(fit), TIED, SIGMA_PX, LEAST_PX)
    alone = 0.2 / np.sqrt(REDUNDANCY) / SIGMA_PX
    assert found.looseness[0, 0] == pytest.approx(2 * alone, rel=0.1)
    assert found.looseness[0, 1] == pytest.approx(alone, rel=0.1)
    np.testing.assert_allclose(found.looseness[-1], alone, rtol=0.1)


def test_none_is_believed_better_than_the_least():
    fit = result(residuals([(0.01, 0.6), (0.01, 0.01)]))
    found = weighed(measured(), fit, TIED, SIGMA_PX, LEAST_PX)
    assert found.looseness[0, 0] == LEAST_PX / SIGMA_PX
    assert found.looseness[0, 1] > 5
    assert np.all(found.looseness[-1] == LEAST_PX / SIGMA_PX)


def test_a_few_gross_errors_change_nothing_much():
    errors = residuals([(0.2, 0.2), (0.2, 0.2)])
    clean = weighed(measured(), result(errors), TIED, SIGMA_PX, LEAST_PX).looseness[0]
    rng = np.random.default_rng(4)
    gross = rng.random(TIED) < 0.03
    errors[gross] += rng.choice([-30.0, 30.0], (gross.sum(), 2))
    spoilt = weighed(measured(), result(errors), TIED, SIGMA_PX, LEAST_PX).looseness[0]
    assert spoilt == pytest.approx(clean, rel=0.2)


SHARED = 300
STATED = np.concatenate([np.ones(TIED), np.full(2 * VIEWS * SHARED, 6.0)])[:, None] * np.ones(2)


def test_a_shared_mark_is_worth_one_matching_however_often_it_is_followed():
    errors = residuals([(0.2, 0.2)] * 2, SHARED, shared_px=0.05)
    fit = result(errors / STATED, SHARED)  # residuals come divided by the looseness
    found = weighed(measured(STATED, SHARED), fit, TIED, SIGMA_PX, LEAST_PX).looseness[-1]
    redundancy = 1 - 3 / (4 * VIEWS)
    np.testing.assert_allclose(found, 0.05 / SIGMA_PX * np.sqrt(VIEWS / redundancy), rtol=0.15)


def test_shared_marks_are_never_looser_than_stated():
    """A seam that is off by pixels as a whole still closes the ring."""
    errors = residuals([(0.2, 0.2)] * 2, SHARED)
    errors[TIED:] = 3.0
    fit = result(errors / STATED, SHARED)
    found = weighed(measured(STATED, SHARED), fit, TIED, SIGMA_PX, LEAST_PX)
    assert np.all(found.looseness[TIED:] == 6.0)


def test_weighing_twice_is_weighing_once():
    errors = residuals([(0.2, 0.2)] * 2, SHARED, shared_px=0.05)
    first = weighed(measured(STATED, SHARED), result(errors / STATED, SHARED), TIED, SIGMA_PX, LEAST_PX)
    second = weighed(first, result(errors / first.looseness, SHARED), TIED, SIGMA_PX, LEAST_PX)
    np.testing.assert_allclose(second.looseness, first.looseness, rtol=1e-9)
