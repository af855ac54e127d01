"""Pairwise ICP settles near the truth on walls and a floor, and its pairs chain into poses."""

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.icp import IcpOptions, compare_icp
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from tests.steel.simulated_network import pose_errors, simulate


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Three stations on targets, and clouds of a room seen from each, in its base's frame."""
    simulated = simulate(3, 1, levelled=True)
    folder, rng = tmp_path_factory.mktemp("clouds"), np.random.default_rng(2)
    clouds = {}
    for station, R, t in zip(
        simulated.survey.stations, simulated.rotations, simulated.translations, strict=True
    ):
        walls = []
        for axis, place in ((0, -25.0), (0, 30.0), (1, -28.0), (1, 26.0), (2, -2.0)):
            points = rng.uniform(-25, 25, (20_000, 3)) * [1, 1, 0.15]
            points[:, axis] = place
            walls.append(points)
        room = np.concatenate(walls) + rng.normal(scale=0.002, size=(100_000, 3))
        clouds[station.name] = folder / f"{station.name}.npy"
        np.save(clouds[station.name], ((room - t) @ R).astype(np.float32))
    return simulated, register(simulated.survey, simulated.found, RegisterOptions(), silent), clouds


def test_pairs_settle_near_the_truth_and_chain(scene):
    simulated, registration, clouds = scene
    found = compare_icp(registration, clouds, IcpOptions(voxel_m=0.4, reach_m=0.8), silent)
    assert [pair.second for pair in found.pairs] == list(registration.order[1:])
    for pair in found.pairs:
        assert pair.matched > 0.9
        assert pair.rms_mm < 20
        assert 0 < pair.offset_mm < 30
    errors, turns = pose_errors(found.poses, simulated)
    assert np.linalg.norm(errors, axis=1).max() < 0.01
    assert np.linalg.norm(turns, axis=1).max() < 0.0006


def test_a_station_without_a_cloud_is_passed_over(scene):
    _, registration, clouds = scene
    few = {name: path for name, path in clouds.items() if name != registration.order[-1]}
    found = compare_icp(registration, few, IcpOptions(voxel_m=0.5), silent)
    assert registration.order[-1] not in {pose.name for pose in found.poses}
