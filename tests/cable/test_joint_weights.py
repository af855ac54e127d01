"""A measurement is believed as far as its like have fitted: by camera, and by direction of the image."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cable.joint_weights import SHARED_TEXTURE, weighed
from pipeline.core.rig import Observations

POINTS, VIEWS, SIGMA_PX = 400, 10, 0.1


def measured(looseness=None, shared=0):
    """Two cameras, each with points seen in ten frames, then a few shared marks."""
    point = np.repeat(np.arange(2 * POINTS), VIEWS)
    count = len(point) + shared
    return Observations(
        frame=np.zeros(count, dtype=np.int64),
        camera=np.concatenate([point // POINTS, np.zeros(shared, dtype=np.int64)]),
        point=np.concatenate([point, 2 * POINTS + np.arange(shared)]),
        pixels=np.zeros((count, 2)),
        looseness=looseness,
    )


def residuals(sigmas_px, shared=0, seed=1):
    rng = np.random.default_rng(seed)
    parts = [rng.normal(0, s, (POINTS * VIEWS, 2)) for s in sigmas_px]
    return SimpleNamespace(residuals=np.concatenate([*parts, np.full((shared, 2), 9.0)]))


def test_each_camera_and_direction_gets_the_spread_of_its_own_residuals():
    found = weighed(measured(), residuals([(0.3, 0.08), (0.2, 0.2)]), 2 * POINTS * VIEWS, SIGMA_PX)
    redundancy = 1 - 3 / (2 * VIEWS)  # three unknowns a point against two residuals a view
    expected = SHARED_TEXTURE * np.array([(0.3, 0.08), (0.2, 0.2)]) / np.sqrt(redundancy) / SIGMA_PX
    np.testing.assert_allclose(found.looseness[0], expected[0], rtol=0.05)
    np.testing.assert_allclose(found.looseness[-1], expected[1], rtol=0.05)


def test_none_is_believed_better_than_stated():
    found = weighed(measured(), residuals([(0.01, 0.3), (0.01, 0.01)]), 2 * POINTS * VIEWS, SIGMA_PX)
    assert found.looseness[0, 0] == 1.0
    assert found.looseness[0, 1] > 5
    assert np.all(found.looseness[-1] == 1.0)


def test_a_few_gross_errors_change_nothing_much():
    fit = residuals([(0.2, 0.2), (0.2, 0.2)])
    clean = weighed(measured(), fit, 2 * POINTS * VIEWS, SIGMA_PX).looseness[0]
    fit.residuals[:: 2 * VIEWS] += 30.0
    assert weighed(measured(), fit, 2 * POINTS * VIEWS, SIGMA_PX).looseness[0] == pytest.approx(
        clean, rel=0.12
    )


def test_shared_marks_keep_what_was_stated_and_weighing_twice_is_weighing_once():
    looseness = np.concatenate([np.ones(2 * POINTS * VIEWS), np.full(5, 6.0)])
    first = weighed(
        measured(looseness, shared=5), residuals([(0.2, 0.2)] * 2, shared=5), 2 * POINTS * VIEWS, SIGMA_PX
    )
    assert np.all(first.looseness[-5:] == 6.0)
    fit = residuals([(0.2, 0.2)] * 2, shared=5)  # residuals come divided by the looseness
    fit.residuals /= first.looseness
    second = weighed(first, fit, 2 * POINTS * VIEWS, SIGMA_PX)
    np.testing.assert_allclose(second.looseness, first.looseness, rtol=1e-9)
