"""The test of an observation does not depend on the weight it had, and equation (7) weighs by it."""

import numpy as np
import pytest

from pipeline.steel import variance
from pipeline.steel.approximate import place_stations
from pipeline.steel.equations import Rows, assemble, covariances, solve
from pipeline.steel.network import build_network
from pipeline.steel.register import shared_features
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.state import groups_of, linearise
from tests.steel.simulated_network import simulate


@pytest.fixture(scope="module")
def network():
    simulated = simulate(6, 3)
    return build_network(simulated.survey, simulated.found), simulated.survey.scanner


def judged_with(network, scanner, weights):
    """Adjust with the weights held, test every observation; (n,) ratios and redundancies."""
    (group,) = groups_of(network, scanner, shared_features(network))
    state = place_stations(network, False, RegisterOptions(), lambda *_: None).state
    held = np.arange(len(network.stations)) == network.base
    for _ in range(5):
        rows = Rows(
            station=group.station,
            feature=group.feature,
            linear=linearise(network, group, state),
            information=np.linalg.inv(group.cofactor) * weights[:, None, None],
        )
        normals = assemble((rows,), len(network.stations), len(network.names) + 1, held)
        state = state.moved(*solve(normals, network.stations), network.kinds)
    found = covariances(normals, held, network.stations)
    return variance.tested(rows, weights, found, normals.places[0], group.cofactor)


@pytest.mark.parametrize("weight", [0.0, 0.3])
def test_the_ratio_is_the_same_whatever_the_weight_was(network, weight):
    count = int(shared_features(network[0])[network[0].feature].sum())
    full = judged_with(*network, np.ones(count))
    for n in (0, 7, count - 1):
        weights = np.ones(count)
        weights[n] = weight
        assert judged_with(*network, weights).ratio[n] == pytest.approx(full.ratio[n], rel=0.02)


def test_redundancies_add_up_to_that_of_the_network(network):
    built, scanner = network
    shared = shared_features(built)
    count = int(shared[built.feature].sum())
    result = judged_with(built, scanner, np.ones(count))
    unknowns = 6 * (len(built.stations) - 1) + 3 * int(shared.sum())
    assert result.redundancy.sum() == pytest.approx(3 * count - unknowns)
    # without gross errors the weighted squares are what the redundancy expects, give or take 3 sigma
    expected = result.redundancy.sum()
    assert abs(result.square.sum() - expected) < 3 * np.sqrt(2 * expected)


def test_equation_7_gives_an_outlier_its_own_variance(network):
    count = int(shared_features(network[0])[network[0].feature].sum())
    result = judged_with(*network, np.ones(count))
    weights = variance.reweighted(result, bound=2.0)
    high = result.ratio >= 2.0
    assert 0 < high.sum() < count / 3
    assert (weights[~high] == 1).all()
    assert weights[high] == pytest.approx(1 / result.ratio[high])
