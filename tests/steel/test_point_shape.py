"""Targets listed with one sigma for all directions: their true shape is found, and sigmas are honest."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.point_shape import stated_alike
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.state import Component, Group
from tests.steel.simulated_network import pose_errors, simulate

OPTIONS = RegisterOptions()
SEEDS = range(8)


def judged(along_m, across_m, stated_m):
    """Errors of stations' places over eight surveys, and their sigmas, metres."""
    errors, sigmas = [], []
    for seed in SEEDS:
        one = simulate(
            12, seed, sigma_m=across_m, along_sigma_m=along_m, stated_sigma_m=stated_m, levelled=True
        )
        poses = register(one.survey, one.found, OPTIONS, silent).poses
        errors.append(pose_errors(poses, one)[0][1:])
        sigmas.append([np.sqrt(np.diag(p.covariance))[3:] for p in poses[1:]])
    return np.array(errors).ravel(), np.array(sigmas).ravel()


@pytest.mark.parametrize(
    ("along_mm", "across_mm"), [(2.0, 0.4), (1.0, 1.0), (0.6, 1.1)], ids=["long", "round", "flat"]
)
def test_stations_are_as_far_off_as_their_sigmas_say(along_mm, across_mm):
    stated_mm = np.sqrt((along_mm**2 + 2 * across_mm**2) / 3)
    errors, sigmas = judged(along_mm / 1000, across_mm / 1000, stated_mm / 1000)
    assert 0.9 <= np.mean(np.abs(errors) < 2 * sigmas) < 0.99
    assert 0.9 < np.sqrt(np.mean(sigmas**2) / np.mean(errors**2)) < 1.3


def test_the_shape_that_is_found_makes_the_stations_better():
    errors, _ = judged(0.002, 0.0003, 0.0012)
    # with the true covariances they would be 0.6 mm, with one sigma for all directions 1.2 mm
    assert np.sqrt(np.mean(errors**2)) < 0.0008


def test_only_targets_stated_alike_in_all_directions_are_reshaped():
    group = Group(
        component=Component.POINT,
        station=np.zeros(2, dtype=np.int64),
        feature=np.arange(2),
        observation=np.arange(2),
        cofactor=np.array([np.eye(3), np.diag([1.0, 1.0, 1.1])]) * 1e-6,
    )
    assert stated_alike(group).tolist() == [True, False]
    assert not stated_alike(replace(group, component=Component.CONTROL)).any()
