"""Unnamed targets get the same name in every station that sees them, by mutual distances alone."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.naming import name_features
from pipeline.steel.records import StationFeatures
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions, TargetOptions
from tests.steel.simulated_network import point, pose_errors, simulate


def unnamed(simulated, seed, strays=2):
    """The features without names, shuffled, with things that are no targets among them."""
    rng = np.random.default_rng(seed)
    hidden, truth = [], []
    for one in simulated.found:
        false = [point("", rng.uniform(-8, 8, 3), 0.002) for _ in range(strays)]
        features = [*one.features, *false]
        order = rng.permutation(len(features))
        truth.append([features[n].name for n in order])
        hidden.append(
            StationFeatures(station=one.station, features=tuple(replace(features[n], name="") for n in order))
        )
    return hidden, truth


def pairs(named, truth):
    """(name given, true name) of everything that got one."""
    return [
        (f.name, true)
        for one, names in zip(named, truth, strict=True)
        for f, true in zip(one.features, names, strict=True)
        if f.name
    ]


@pytest.mark.parametrize("levelled", [True, False])
@pytest.mark.parametrize("seed", [0, 1])
def test_names_are_those_of_the_truth(levelled, seed):
    simulated = simulate(9, seed, levelled=levelled, sigma_m=0.001, nearest=9)
    hidden, truth = unnamed(simulated, seed)
    named = name_features(hidden, "S001", levelled, TargetOptions(), silent)
    given = pairs(named, truth)
    assert len({true for _, true in given}) == len({name for name, _ in given}) == len(set(given))
    assert "" not in {true for _, true in given}
    times = [f.name for one in simulated.found for f in one.features]
    shared = sum(times.count(name) > 1 for name in times)
    assert len(given) > 0.9 * shared


def test_the_named_network_registers():
    simulated = simulate(9, 0, levelled=True, sigma_m=0.001, nearest=9)
    hidden, _ = unnamed(simulated, 3)
    named = name_features(hidden, "S001", True, TargetOptions(), silent)
    result = register(simulated.survey, named, RegisterOptions(), silent)
    errors, _ = pose_errors(result.poses, simulated)
    assert np.linalg.norm(errors, axis=1).max() < 0.01
    assert not result.gross


def test_names_given_by_hand_are_kept_and_handed_on():
    simulated = simulate(5, 2, levelled=True, sigma_m=0.001)
    hidden, truth = unnamed(simulated, 0, strays=0)
    mark = truth[1][0]
    by_hand = [replace(hidden[1].features[0], name="pillar"), *hidden[1].features[1:]]
    hidden[1] = replace(hidden[1], features=tuple(by_hand))
    given = set(pairs(name_features(hidden, "S001", True, TargetOptions(), silent), truth))
    assert ("pillar", mark) in given
    assert {name for name, true in given if true == mark} == {"pillar"}


def test_what_fits_at_two_places_is_left_unnamed():
    # a square: the second station could stand at any of four places
    square = np.array([[3.0, 3, 1], [-3, 3, 1], [-3, -3, 1], [3, -3, 1]])
    found = [
        StationFeatures(station=name, features=tuple(point("", p, 0.001) for p in square))
        for name in ("S1", "S2")
    ]
    named = name_features(found, "S1", True, TargetOptions(), silent)
    assert not any(f.name for one in named for f in one.features)
