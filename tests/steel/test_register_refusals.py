"""What cannot be registered is told in one sentence that names the station."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel.records import StationFeatures
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from tests.steel.simulated_network import point, simulate, survey_of


def refusal(simulated, found):
    with pytest.raises(StageError) as caught:
        register(simulated.survey, found, RegisterOptions(), silent)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def only(one, names):
    return replace(one, features=tuple(f for f in one.features if f.name in names))


def test_too_few_common_targets_are_told_with_the_station():
    simulated = simulate(6, 0)
    others = {f.name for one in simulated.found[:5] for f in one.features}
    two = [f.name for f in simulated.found[5].features if f.name in others][:2]
    found = [*simulated.found[:5], only(simulated.found[5], two)]
    said = refusal(simulated, found)
    assert "station S006 shares only 2 targets" in said
    assert "at least 3" in said


def test_a_station_without_targets_or_without_common_ones_is_told():
    simulated = simulate(6, 0)
    nothing = [*simulated.found[:5], replace(simulated.found[5], features=())]
    assert "station S006 has no target that could be named" in refusal(simulated, nothing)
    own = tuple(replace(f, name=f"own{n}") for n, f in enumerate(simulated.found[5].features))
    alone = [*simulated.found[:5], replace(simulated.found[5], features=own)]
    assert "station S006 has no target in common" in refusal(simulated, alone)


def test_a_network_in_two_parts_is_told():
    simulated = simulate(6, 0)
    parts = [
        replace(one, features=tuple(replace(f, name=f"{f.name}-{s // 3}") for f in one.features))
        for s, one in enumerate(simulated.found)
    ]
    assert "the network falls apart: 3 of 6 stations (S004, S005, S006)" in refusal(simulated, parts)


@pytest.mark.parametrize("levelled", [True, False])
def test_mirrored_coordinates_are_told(levelled):
    simulated = simulate(6, 0, levelled=levelled)
    mirrored = tuple(replace(f, place=f.place * [1, -1, 1]) for f in simulated.found[3].features)
    found = [replace(one, features=mirrored) if s == 3 else one for s, one in enumerate(simulated.found)]
    assert "station S004 is mirrored" in refusal(simulated, found)


@pytest.mark.parametrize(
    ("factor", "unit"), [(1000, "millimetres"), (1 / 0.3048, "feet"), (100, "centimetres")]
)
def test_mixed_units_are_told(factor, unit):
    simulated = simulate(6, 0)
    scaled = tuple(replace(f, place=f.place * factor) for f in simulated.found[2].features)
    found = [replace(one, features=scaled) if s == 2 else one for s, one in enumerate(simulated.found)]
    said = refusal(simulated, found)
    assert "station S003" in said
    assert unit in said


def test_collinear_common_targets_are_told():
    rng = np.random.default_rng(0)
    line = np.outer(np.linspace(-8, 9, 5), [0.8, 0.6, 0.05]) + np.array([1.0, 2, 0])
    names = [f"T{n}" for n in range(5)]
    stations = ["S1", "S2"]
    turns = Rotation.random(2, random_state=0).as_matrix()
    found = [
        StationFeatures(
            station=station,
            features=tuple(
                point(n, p @ R + rng.normal(scale=0.002, size=3), 0.002)
                for n, p in zip(names, line, strict=True)
            ),
        )
        for station, R in zip(stations, turns, strict=True)
    ]
    with pytest.raises(StageError, match=r"station S2 shares with the others \(.*\) lie on one line"):
        register(survey_of(stations), found, RegisterOptions(), silent)


def test_targets_named_at_random_are_told():
    simulated = simulate(4, 0)
    names = [f.name for f in simulated.found[3].features]
    turned = tuple(
        replace(f, name=name)
        for f, name in zip(simulated.found[3].features, names[3:] + names[:3], strict=True)
    )
    assert "do not lie as they do there" in refusal(
        simulated, [*simulated.found[:3], replace(simulated.found[3], features=turned)]
    )
