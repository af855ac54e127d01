"""Moved and misnamed targets are named, with whom they are told, and harm nobody."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.chained import compare_chained
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import GrossKind
from tests.steel.simulated_network import simulate


def registered(simulated, found=None):
    return register(simulated.survey, found or simulated.found, RegisterOptions(), silent)


def changed(simulated, station, target, **new):
    """The features with one of a station's changed."""
    return [
        replace(
            one,
            features=tuple(
                replace(f, **new) if one.station == station and f.name == target else f for f in one.features
            ),
        )
        for one in simulated.found
    ]


def place_of(simulated, station, target):
    features = next(one.features for one in simulated.found if one.station == station)
    return next(f.place for f in features if f.name == target)


def test_one_moved_and_one_misnamed_target_are_named_and_harm_nobody():
    simulated = simulate(12, 5, levelled=True)
    clean = registered(simulated)
    moved = place_of(simulated, "S005", target := simulated.found[4].features[2].name)
    moved = moved + np.array([0.03, -0.04, 0.0])
    found = changed(simulated, "S005", target, place=moved)
    other = next(
        f.name for f in found[8].features if f.name != target and clean.seen_by[index_of(clean, f.name)] > 3
    )
    own, known = ({f.name for f in features} for features in (found[8].features, clean.features))
    wrong = next(name for name in simulated.targets if name in known - own)
    found[8] = replace(
        found[8], features=tuple(replace(f, name=wrong) if f.name == other else f for f in found[8].features)
    )
    result = registered(simulated, found)
    verdicts = {(error.station, error.target): error for error in result.gross}
    assert set(verdicts) == {("S005", target), ("S009", wrong)}
    first, second = verdicts["S005", target], verdicts["S009", wrong]
    assert (first.kind, second.kind, second.fits) == (GrossKind.MOVED, GrossKind.MISNAMED, other)
    assert first.size_mm == pytest.approx(50, abs=8)
    turned = simulated.rotations[4] @ [30.0, -40.0, 0.0]
    assert np.linalg.norm(np.array(first.offset_mm) - turned) < 8
    shifts = [
        np.abs(a.translation - b.translation) / np.sqrt(np.diag(a.covariance)[3:])
        for a, b in zip(clean.poses[1:], result.poses[1:], strict=True)
    ]
    assert np.max(shifts) < 1.5


def index_of(registration, name):
    return [f.name for f in registration.features].index(name)


def test_a_target_that_moves_during_the_survey_is_told_as_one_group():
    simulated = simulate(9, 2, levelled=True, nearest=12)
    seen = [s for s, one in enumerate(simulated.found) if "T009" in {f.name for f in one.features}]
    assert len(seen) > 3
    late = seen[len(seen) // 2 + len(seen) % 2 :]
    found = list(simulated.found)
    for s in late:
        shift = simulated.rotations[s].T @ np.array([0.0, 0.05, 0.0])
        found[s] = replace(
            found[s],
            features=tuple(
                replace(f, place=f.place + shift) if f.name == "T009" else f for f in found[s].features
            ),
        )
    result = registered(simulated, found)
    names = tuple(simulated.survey.stations[s].name for s in late)
    assert {error.station for error in result.gross} == set(names)
    for error in result.gross:
        assert (error.target, error.kind, error.together) == ("T009", GrossKind.MOVED, names)
        assert np.linalg.norm(np.array(error.offset_mm) - [0, 50, 0]) < 10


def test_a_target_that_two_see_differently_is_told_with_both():
    simulated = simulate(6, 4, levelled=True)
    times = [name for one in simulated.found for name in (f.name for f in one.features)]
    twice = next(name for name in times if times.count(name) == 2)
    first, second = [one.station for one in simulated.found if twice in {f.name for f in one.features}]
    found = changed(
        simulated, second, twice, place=place_of(simulated, second, twice) + np.array([0, 0.06, 0])
    )
    (error,) = registered(simulated, found).gross
    assert {error.station, error.instead} == {first, second}


def test_chaining_leaves_out_the_same_targets():
    """Compared with a chain that was told only what the adjustment kept."""
    simulated = simulate(12, 5, levelled=True)
    target = simulated.found[4].features[2].name
    moved = place_of(simulated, "S005", target) + np.array([0.03, -0.04, 0.0])
    found = changed(simulated, "S005", target, place=moved)
    result = registered(simulated, found)
    kept = [
        replace(one, features=tuple(f for f in one.features if (one.station, f.name) != ("S005", target)))
        for one in found
    ]
    assert {(error.station, error.target) for error in result.gross} == {("S005", target)}
    chained, without = (compare_chained(simulated.survey, those, result, silent) for those in (found, kept))
    for one, other in zip(chained.poses, without.poses, strict=True):
        np.testing.assert_allclose(one.translation, other.translation, atol=1e-12)
