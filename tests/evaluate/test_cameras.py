"""Errors of the exterior orientation are found as they were put in, before and after the fit."""

from math import radians

import numpy as np
import pytest

from pipeline.evaluate import evaluate
from tests.evaluate.written_run import TRAVEL_M, turn


def test_a_rigid_motion_of_the_whole_is_seen_as_it_stands_and_gone_after_the_fit(case):
    Q, shift = turn(1, 0.3), np.array([0.0, 0.002, 0.0])
    found = evaluate(*case(change=lambda R, c: (R @ Q.T, Q @ c + shift))).cameras
    stands, fitted = found.as_they_stand[-1], found.fitted[-1]
    assert stands.along_mm == pytest.approx(2.0, abs=1e-6)
    assert stands.around_mm == pytest.approx(300 * radians(0.3), rel=1e-3)
    assert stands.radial_mm < 0.01
    assert stands.attitude_deg == pytest.approx(0.3, abs=1e-6)
    assert fitted.position_mm < 1e-6
    assert fitted.attitude_deg < 1e-6
    assert found.fit_rotation_deg == pytest.approx(0.3, abs=1e-6)
    assert found.fit_translation_mm == pytest.approx(2.0, abs=1e-6)


def test_one_block_alone_is_fitted_though_its_centres_lie_on_a_line(case):
    Q = turn(1, 5.0)
    fitted = evaluate(*case(change=lambda R, c: (R @ Q.T, Q @ c), blocks=(0,))).cameras.fitted
    assert [row.block for row in fitted] == ["Block1", "all"]
    assert fitted[0].position_mm < 1e-6
    assert fitted[0].attitude_deg < 1e-6


def test_a_wider_ring_stays_after_the_fit(case):
    found = evaluate(*case(change=lambda R, c: (R, c * [1.002, 1, 1.002]))).cameras
    for rows in (found.as_they_stand, found.fitted):
        assert rows[-1].radial_mm == pytest.approx(0.6, abs=1e-3)
        assert rows[-1].around_mm + rows[-1].along_mm < 1e-3


def test_attitude_errors_of_single_frames_stay_after_the_fit(case):
    def nod(R, c):
        return turn(0, 0.1 if round(c[1] / TRAVEL_M * 11) % 2 else -0.1) @ R, c

    found = evaluate(*case(change=nod)).cameras
    assert found.as_they_stand[-1].attitude_deg == pytest.approx(0.1, rel=1e-5)
    assert found.fitted[-1].attitude_deg == pytest.approx(0.1, rel=0.01)


def test_selected_frames_are_compared_with_their_own_truth(case):
    found = evaluate(*case(frames=[0, 5, 11])).cameras.as_they_stand
    assert found[-1].frames == 12
    assert found[-1].position_mm < 1e-9
