"""Errors that stations have in common do not average out over them."""

import numpy as np
import pytest

from pipeline.steel.member_records import StationShare
from pipeline.steel.records import StationPose, chosen_poses
from pipeline.steel.shares import with_stations

SIGMA_M = 1e-3
NONE = np.zeros((0, 6, 6))


def station(name, among):
    return StationPose(
        name=name,
        rotation=np.eye(3),
        translation=np.zeros(3),
        covariance=SIGMA_M**2 * np.eye(6),
        among=np.array(among).reshape(-1, 6, 6),
    )


def mean_of_two():
    """A place that is the mean of what two stations see of it: it follows each of them by half."""
    gain = 0.5 * np.eye(3, 7, k=3)
    return StationShare(stations=np.array([0, 1]), gains=np.stack([gain, gain]))


@pytest.mark.parametrize(
    ("correlation", "left"), [(None, np.sqrt(0.5)), (0.0, np.sqrt(0.5)), (1.0, 1.0), (-1.0, 0.0)]
)
def test_the_mean_of_two_stations_is_as_good_as_their_errors_are_unlike(correlation, left):
    own = SIGMA_M**2 * np.eye(6)
    among = ([NONE] * 2) if correlation is None else [[own, correlation * own], [correlation * own, own]]
    stations = (station("A", among[0]), station("B", among[1]))
    found = with_stations(np.zeros((3, 3)), mean_of_two(), stations, 0.0)
    assert np.sqrt(np.diag(found)) == pytest.approx(np.full(3, left * SIGMA_M), abs=1e-12)


def test_noise_and_a_common_error_of_the_ranges_come_on_top():
    gain = np.zeros((1, 7))
    gain[0, 6] = 2.0
    share = StationShare(stations=np.array([1]), gains=gain[None])
    stations = (station("A", NONE), station("B", NONE))
    found = with_stations(np.array([[9e-6]]), share, stations, 2e-3)
    assert found[0, 0] == pytest.approx(9e-6 + 16e-6)


def test_chosen_stations_keep_what_they_know_of_each_other():
    blocks = np.arange(9.0)[:, None, None] * np.ones((9, 6, 6))
    stations = tuple(station(name, blocks[3 * n : 3 * n + 3]) for n, name in enumerate("ABC"))
    first, second = chosen_poses(stations, ["C", "A"])
    assert (first.name, second.name) == ("C", "A")
    assert first.among[:, 0, 0].tolist() == [8.0, 6.0]
    assert second.among[:, 0, 0].tolist() == [2.0, 0.0]
