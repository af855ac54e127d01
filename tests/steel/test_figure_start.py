"""Stations that share too few targets are placed on the axes and planes that were named by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel.chained import compare_chained
from pipeline.steel.figure_register import register_with_figures
from pipeline.steel.figure_start import Common, figure_motion
from pipeline.steel.records import FeatureKind
from pipeline.steel.registration_options import RegisterOptions
from tests.steel.simulated_network import pose_errors, simulate
from tests.steel.test_figures import seen

POINT, LINE, PLANE = FeatureKind.POINT, FeatureKind.LINE, FeatureKind.PLANE
COLUMN, OTHER = (LINE, [4.0, 1, 1], [0, 0, 1]), (LINE, [1.0, 6, 1], [0, 0.002, 1])
FLOOR, WALL, SIDE = (
    (PLANE, [3.0, 3, -1.6], [0, 0, 1]),
    (PLANE, [9.0, 0, 1], [-1, 0, 0]),
    (PLANE, [0.0, 9, 1], [0, -1, 0.1]),
)
BEAM, SLOPED = (LINE, [3.0, 2, 4], [1, 0, 0.1]), (LINE, [6.0, 5, 3], [0.3, 1, 0.6])


def common(things, R, t, seed=0):
    """Things in the target's frame and, slid along themselves and told either way, in the source's."""
    rng = np.random.default_rng(seed)
    told = []
    for kind, place, direction in things:
        d = np.zeros(3) if kind is POINT else np.array(direction, dtype=float) / np.linalg.norm(direction)
        slide = rng.uniform(-1, 1) * d if kind is LINE else np.zeros(3)
        if kind is PLANE:
            slide = np.cross(d, rng.normal(size=3))
        sign = rng.choice([-1.0, 1.0]) if kind is LINE else 1.0
        told.append(
            Common(
                kind=kind,
                source=R.T @ (np.array(place) + slide + rng.normal(scale=0.002, size=3) - t),
                source_direction=sign * R.T @ d,
                target=np.array(place, dtype=float),
                target_direction=d,
            )
        )
    return told


LEVEL = [
    (COLUMN, OTHER, FLOOR),
    (COLUMN, WALL, FLOOR),
    (FLOOR, WALL, SIDE),
    (COLUMN, BEAM, (POINT, [2.0, 2, 2], None)),
    ((POINT, [2.0, 2, 2], None), (POINT, [2.0, 2, 0], None), WALL),
]
FREE = [
    (FLOOR, WALL, SIDE),
    (COLUMN, OTHER, FLOOR),
    (BEAM, SLOPED, FLOOR),
    (COLUMN, WALL, FLOOR),
    ((POINT, [2.0, 2, 2], None), (POINT, [6.0, 2, 0], None), WALL),
]


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
@pytest.mark.parametrize(("things", "level"), [*((x, True) for x in LEVEL), *((x, False) for x in FREE)])
def test_what_holds_a_station_places_it(things, level, seed):
    turn = Rotation.from_rotvec([0, 0, seed + 0.5]) if level else Rotation.random(random_state=seed)
    R, t = turn.as_matrix(), np.array([5.0, -3, 0.4])
    rotation, translation = figure_motion(common(things, R, t, seed), 0.15, level=level)
    assert Rotation.from_matrix(rotation @ R.T).magnitude() < 0.01
    assert np.linalg.norm(translation - t) < 0.05


PLUMB, BESIDE = (LINE, [4.0, 1, 1], [0, 0, 1]), (LINE, [1.0, 6, 1], [0, 0, 1])
CROSSING = (LINE, [4.0, 1, 3], [1, 0, 0])


@pytest.mark.parametrize(
    ("things", "level"),
    [
        ((PLUMB, FLOOR), True),  # turns about the column
        ((PLUMB, BESIDE), True),  # slides along both
        ((WALL, FLOOR), True),  # slides along the wall
        ((FLOOR, WALL), False),
        ((PLUMB, CROSSING), True),  # half a turn about the column fits as well
        ((PLUMB, CROSSING), False),  # or about the beam
        ((FLOOR,), True),
        ((), True),
    ],
)
def test_what_leaves_a_motion_open_places_nothing(things, level):
    R = Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    assert figure_motion(common(things, R, np.array([5.0, -3, 0.4])), 0.15, level=level) is None


def test_what_does_not_fit_together_places_nothing():
    R, t = Rotation.from_rotvec([0, 0, 1.0]).as_matrix(), np.array([5.0, -3, 0.4])
    shared = common((COLUMN, OTHER, FLOOR, WALL), R, t)
    assert figure_motion(shared, 0.15, level=True) is not None
    moved = [replace(shared[0], source=shared[0].source + np.array([1.0, 0, 0])), *shared[1:]]
    assert figure_motion(moved, 0.15, level=True) is None


def hall(seed, *, levelled, things, far=2):
    """Five stations; the last ``far`` see no target of the others, and all see the things, named by hand."""
    simulated = simulate(5, seed, levelled=levelled)
    rng, found = np.random.default_rng(seed), []
    stations = zip(simulated.found, simulated.rotations, simulated.translations, strict=True)
    for number, (one, R, t) in enumerate(stations):
        points = one.features
        if number >= 5 - far:
            points = tuple(replace(f, name=f"{f.name}-{number}") for f in points)
        more = tuple(
            replace(seen(kind, np.array(place), d, R, t, rng, 0.3, reach_m=4.0), name=name)
            for name, (kind, place, d) in things.items()
        )
        found.append(replace(one, features=(*points, *more)))
    return simulated, found


def facing(found):
    """Normals of planes towards the station, as a search finds them."""
    return [
        replace(
            one,
            features=tuple(
                replace(f, frame=f.frame * [[1], [-1], [-1]], direction=-f.direction)
                if f.kind is PLANE and f.direction @ f.place > 0
                else f
                for f in one.features
            ),
        )
        for one in found
    ]


@pytest.mark.parametrize("levelled", [True, False])
def test_stations_without_common_targets_are_registered_on_what_was_named(levelled):
    columns = {"8-N": (LINE, [3.0, -2, 0], [0.002, 0, 1]), "7-P": (LINE, [6.0, 7, 0], [0, -0.003, 1])}
    planes = {"floor": (PLANE, [4.0, 4, -9], [0, 0, 1]), "wall": (PLANE, [40.0, 2, 0], [-1, 0, 0])}
    errors, standardised = [], []
    for seed in range(3):
        simulated, found = hall(seed, levelled=levelled, things={**columns, **planes})
        survey, options = simulated.survey, RegisterOptions()
        features, registration = register_with_figures(survey, facing(found), options, silent)
        assert not registration.gross
        places, turns = pose_errors(registration.poses, simulated)
        sigmas = np.array([np.sqrt(np.diag(pose.covariance)) for pose in registration.poses])
        errors.append(places[1:])
        standardised.append(np.concatenate([turns, places], axis=1)[1:] / sigmas[1:])
        named = {f.name for one in features for f in one.features if f.kind is not POINT}
        assert named == {*columns, *planes}
        # chaining knows targets only: it leaves those stations out and goes on
        chained = compare_chained(survey, features, registration, silent)
        assert [pose.name for pose in chained.poses] == ["S001", "S002", "S003"]
        assert [link.station for link in chained.links].count("S004") == 0
    assert 0.0001 < np.sqrt(np.mean(np.square(errors))) < 0.004
    assert 0.5 < np.sqrt(np.mean(np.square(standardised))) < 1.5


def test_too_little_to_hold_a_station_is_told_by_its_names():
    things = {"8-N": (LINE, [3.0, -2, 0], [0, 0, 1]), "floor": (PLANE, [4.0, 4, -9], [0, 0, 1])}
    simulated, found = hall(0, levelled=True, things=things, far=1)
    with pytest.raises(StageError) as caught:
        register_with_figures(simulated.survey, facing(found), RegisterOptions(), silent)
    assert (
        "the axes and planes that station S005 shares with those placed (8-N, floor) do not hold it"
        in str(caught.value)
    )
    assert "station.names" in str(caught.value)
    assert "\n" not in str(caught.value)
