"""Errors of a lens are told in their units and in pixels."""

import numpy as np
import pytest

from pipeline.evaluate import evaluate


def test_a_longer_focal_length_moves_the_corner_by_its_share(case):
    (row, *_) = evaluate(*case(lens={"focal_px": 727.2})).lenses
    assert row.focal_percent == pytest.approx(1.0)
    # undistorted, the corner of lambda = -0.02 lies at half the diagonal / 0.98
    assert row.displacement_px == pytest.approx(np.hypot(480, 300) / 0.98 * (1 - 1 / 1.01), rel=1e-6)


def test_lambda_is_compared_in_the_unit_of_the_truth(case):
    half_width = {"division_lambda": -0.02 * (480 / np.hypot(480, 300)) ** 2, "lambda_radius": "half-width"}
    (row, *_) = evaluate(*case(lens=half_width)).lenses
    assert row.lambda_error == pytest.approx(0, abs=1e-12)
    assert row.displacement_px < 1e-9


def test_a_wrong_lambda_is_told_in_its_unit_and_in_pixels(case):
    (row, *_) = evaluate(*case(lens={"division_lambda": -0.03})).lenses
    corner = np.hypot(480, 300)
    assert row.lambda_error == pytest.approx(-0.01)
    assert row.displacement_px == pytest.approx(corner / 0.97 - corner / 0.98, rel=1e-6)


def test_a_lens_that_folds_is_infinitely_wrong(case):
    (row, *_) = evaluate(*case(lens={"division_lambda": -1.5})).lenses
    assert row.displacement_px == float("inf")
