"""Axes and planes matched between stations and registered on: the right ones, and only clear ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.core.events import silent
from pipeline.steel.figure_register import register_with_figures
from pipeline.steel.figures import name_figures
from pipeline.steel.records import Feature, FeatureKind, StationFeatures, StationPose
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import GrossKind
from tests.steel.simulated_network import pose_errors, simulate

OFFSET_M, SLOPE = 0.0004, 0.00006


def frame_about(direction):
    d = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    u = np.cross(d, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(d, u), d])


def seen(kind, place, direction, R, t, rng, slide=0.0, reach_m=2.0, radius_m=0.15):
    """A figure as a station at (R, t) measures it: with noise, its own place along it, either sign."""
    frame = frame_about(direction)
    step = slide * frame[2] if kind is FeatureKind.LINE else slide * frame[0]
    offsets = rng.normal(scale=OFFSET_M, size=2)
    lean = rng.normal(scale=SLOPE, size=2)
    moved = place + step + (offsets @ frame[:2] if kind is FeatureKind.LINE else offsets[0] * frame[2])
    turned = frame_about(frame[2] + lean @ frame[:2])
    sigmas = [OFFSET_M, OFFSET_M, SLOPE, SLOPE] if kind is FeatureKind.LINE else [OFFSET_M, SLOPE, SLOPE]
    if kind is FeatureKind.LINE and rng.uniform() < 0.5:
        turned = turned * [[1], [-1], [-1]]
    return Feature(
        kind=kind,
        name="",
        place=R.T @ (moved - t),
        direction=R.T @ turned[2],
        frame=turned @ R,
        covariance=np.diag(np.square(sigmas)),
        radius_m=radius_m if kind is FeatureKind.LINE else 0.0,
        points=1000,
        rms_m=0.002,
        reach_m=reach_m,
    )


def figures(rng, count=14):
    """Columns and walls over a hall: kind, place, direction."""
    columns = [
        (FeatureKind.LINE, np.array([*rng.uniform(-4, 20, 2), 1.0]), [*rng.normal(scale=0.003, size=2), 1])
        for _ in range(count)
    ]
    walls = [
        (FeatureKind.PLANE, np.array([-6.0, 8, 1]), [1, 0, 0]),
        (FeatureKind.PLANE, np.array([8.0, -6, 1]), [0, 1, 0]),
        (FeatureKind.PLANE, np.array([8.0, 8, -1.6]), [0, 0, 1]),
    ]
    return [*columns, *walls]


def with_figures(simulated, seed, share=0.7):
    """The stations' features and the figures that each sees, and of each which figure it truly is."""
    rng = np.random.default_rng(seed)
    there, found, truth = figures(rng), [], {}
    for one, R, t in zip(simulated.found, simulated.rotations, simulated.translations, strict=True):
        more = []
        for number, (kind, place, direction) in enumerate(there):
            if rng.uniform() < share:
                slide = rng.uniform(-0.5, 0.5)
                more.append(seen(kind, place, direction, R, t, rng, slide, reach_m=2.0 if slide else 8.0))
                truth[one.station, len(one.features) + len(more) - 1] = number
        found.append(replace(one, features=(*one.features, *more)))
    return found, truth


def given(found, truth):
    """Pairs (name, true figure) over all named figures."""
    return {
        (f.name, truth[one.station, n])
        for one in found
        for n, f in enumerate(one.features)
        if f.kind is not FeatureKind.POINT and f.name
    }


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_each_figure_gets_one_name_and_each_name_one_figure(seed):
    simulated = simulate(8, seed, levelled=True)
    found, truth = with_figures(simulated, seed)
    poses = register(simulated.survey, found, RegisterOptions(), silent).poses
    pairs = given(name_figures(found, poses), truth)
    assert len({name for name, _ in pairs}) == len({figure for _, figure in pairs}) == len(pairs)
    assert len(pairs) >= 12  # of 17; columns may stand too near to each other


def test_two_columns_nearer_than_the_stations_are_known_are_not_told_apart():
    rng = np.random.default_rng(5)
    there = np.array([4.0, 0.0, 1.0])
    poses = [
        StationPose(name="S1", rotation=np.eye(3), translation=np.zeros(3), covariance=np.zeros((6, 6))),
        StationPose(
            name="S2",
            rotation=Rotation.from_rotvec([0, 0, 1.0]).as_matrix(),
            translation=np.array([8.0, 1, 0]),
            covariance=np.diag([1e-4] * 3 + [0.006] * 3) ** 2,
        ),
    ]

    def sightings(places):
        return [
            StationFeatures(
                station=pose.name,
                features=tuple(
                    seen(FeatureKind.LINE, p, [0, 0, 1], pose.rotation, pose.translation, rng) for p in places
                ),
            )
            for pose in poses
        ]

    def names(places):
        return [[f.name for f in one.features] for one in name_figures(sightings(places), poses)]

    assert names([there]) == [["A001"], ["A001"]]
    assert names([there, there + np.array([0.5, 0, 0])]) == [["A001", "A002"], ["A001", "A002"]]
    assert names([there, there + np.array([0.02, 0, 0])]) == [["", ""], ["", ""]]


def standing(name, sigma_m, among=()):
    """A station at the origin, known to ``sigma_m``; ``among`` as in :class:`StationPose`."""
    covariance = np.diag([0.0] * 3 + [sigma_m] * 3) ** 2
    return StationPose(
        name=name,
        rotation=np.eye(3),
        translation=np.zeros(3),
        covariance=covariance,
        **({"among": np.array(among)} if len(among) else {}),
    )


def names_of(places_m, poses, seed=7):
    """Names that plumb columns at (x, 0, 1), for each station those that it sees, are given."""
    rng = np.random.default_rng(seed)
    found = [
        StationFeatures(
            station=pose.name,
            features=tuple(
                seen(FeatureKind.LINE, np.array([4.0 + x, 0, 1]), [0, 0, 1], np.eye(3), np.zeros(3), rng)
                for x in places
            ),
        )
        for pose, places in zip(poses, places_m, strict=True)
    ]
    return [[f.name for f in one.features] for one in name_figures(found, poses)]


def test_stations_that_are_off_alike_must_agree_better_than_each_is_known():
    """Two columns 25 mm apart: one, to stations known to 6 mm each; two, to stations off by the same."""
    places = [[0.0], [0.025]]
    assert names_of(places, [standing("S1", 0.006), standing("S2", 0.006)]) == [["A001"], ["A001"]]
    alike = [standing("S1", 0.006).covariance] * 2
    assert names_of(places, [standing("S1", 0.006, alike), standing("S2", 0.006, alike)]) == [[""], [""]]


def test_a_chain_of_matches_that_leads_back_to_another_figure_is_not_trusted():
    """Each link is clear, but the first station sees two columns, 87 mm apart."""
    poses = [standing("S1", 0.0), standing("S2", 0.006), standing("S3", 0.006)]
    assert names_of([[0.0], [0.025], [0.03]], poses) == [["A001"], ["A001"], ["A001"]]
    assert names_of([[0.0, 0.087], [0.025], [0.062]], poses) == [["", ""], [""], [""]]


def test_pieces_of_one_axis_that_stations_see_at_different_heights_are_not_matched():
    rng = np.random.default_rng(6)
    pose = StationPose(name="S", rotation=np.eye(3), translation=np.zeros(3), covariance=np.zeros((6, 6)))
    low, high = (
        seen(FeatureKind.LINE, np.array([4.0, 0, z]), [0, 0, 1], np.eye(3), np.zeros(3), rng, reach_m=1.0)
        for z in (0.0, 3.0)
    )
    found = [StationFeatures(station=n, features=(f,)) for n, f in (("S1", low), ("S2", high))]
    named = name_figures(found, [replace(pose, name="S1"), replace(pose, name="S2")])
    assert [f.name for one in named for f in one.features] == ["", ""]


@pytest.mark.parametrize("nearest", [5, 8])
def test_stations_stand_better_with_figures_and_their_sigmas_say_how_well(nearest):
    """Few targets leave the heading loose: columns and walls hold it."""
    before, after, standardised = [], [], []
    for seed in range(4):
        simulated = simulate(6, seed, levelled=True, nearest=nearest)
        found, _ = with_figures(simulated, seed)
        alone = register(simulated.survey, simulated.found, RegisterOptions(), silent)
        _, together = register_with_figures(simulated.survey, found, RegisterOptions(), silent)
        before.append(pose_errors(alone.poses, simulated)[0][1:])
        places, turns = pose_errors(together.poses, simulated)
        after.append(places[1:])
        sigmas = np.array([np.sqrt(np.diag(pose.covariance)) for pose in together.poses])
        standardised.append(np.concatenate([turns, places], axis=1)[1:] / sigmas[1:])
        assert not together.gross
    assert np.sqrt(np.mean(np.square(after))) < 0.6 * np.sqrt(np.mean(np.square(before)))
    assert 0.5 < np.sqrt(np.mean(np.square(standardised))) < 1.4
    assert np.mean(np.abs(standardised) < 2) > 0.9


def test_a_wrong_match_is_dropped_and_is_no_gross_error():
    """A column that moved by 10 mm between two visits (a crane's leg) is not the surveyor's mistake."""
    simulated = simulate(6, 1, levelled=True)
    found, _ = with_figures(simulated, 1, share=1.0)
    number = len(simulated.found[0].features)
    moved = found[0].features[number]
    one = replace(
        found[0],
        features=(
            *found[0].features[:number],
            replace(moved, place=moved.place + 0.01 * moved.frame[0]),
            *found[0].features[number + 1 :],
        ),
    )
    _, together = register_with_figures(simulated.survey, [one, *found[1:]], RegisterOptions(), silent)
    assert not together.gross
    places, _ = pose_errors(together.poses, simulated)
    assert np.abs(places).max() < 0.0015


def named_by_hand(found, truth, names, stations):
    """The stations numbered, with names for true figures: {figure: name}."""
    return [
        replace(
            one,
            features=tuple(
                replace(f, name=names[truth[one.station, n]])
                if s in stations and truth.get((one.station, n)) in names
                else f
                for n, f in enumerate(one.features)
            ),
        )
        for s, one in enumerate(found)
    ]


def test_names_given_by_hand_are_kept_and_spread_to_whoever_sees_the_same():
    simulated = simulate(6, 2, levelled=True)
    found, truth = with_figures(simulated, 2, share=1.0)
    by_hand = named_by_hand(found, truth, {0: "8-N", 14: "A001", 16: "floor"}, {1, 3})
    features, registration = register_with_figures(simulated.survey, by_hand, RegisterOptions(), silent)
    assert not registration.gross
    pairs = given(features, truth)
    assert {("8-N", 0), ("A001", 14), ("floor", 16)} <= pairs
    assert len({name for name, _ in pairs}) == len({figure for _, figure in pairs}) == len(pairs)
    for name, figure in (("8-N", 0), ("floor", 16)):
        with_it = [one.station for one in features if any(f.name == name for f in one.features)]
        assert len(with_it) == 6, figure


def test_two_names_by_hand_for_one_figure_are_the_surveyors_word():
    simulated = simulate(4, 2, levelled=True)
    found, truth = with_figures(simulated, 2, share=1.0)
    poses = register(simulated.survey, found, RegisterOptions(), silent).poses
    two = named_by_hand(named_by_hand(found, truth, {0: "8-N"}, {1}), truth, {0: "7-P"}, {2})
    names = [
        {f.name for n, f in enumerate(one.features) if truth.get((one.station, n)) == 0}
        for one in name_figures(two, poses)
    ]
    assert names == [{""}, {"8-N"}, {"7-P"}, {""}]


@pytest.mark.parametrize("other", [1, 15])
def test_a_figure_named_wrongly_by_hand_is_a_gross_error_and_the_rest_is_unharmed(other):
    """One station calls another column, or the wall across, by the name that two others use."""
    simulated = simulate(6, 1, levelled=True)
    found, truth = with_figures(simulated, 1, share=1.0)
    name, figure = ("8-N", 0) if other == 1 else ("west wall", 14)
    right = named_by_hand(found, truth, {figure: name}, {0, 2, 3})
    wrong = named_by_hand(right, truth, {other: name}, {4})
    _, registration = register_with_figures(simulated.survey, wrong, RegisterOptions(), silent)
    (error,) = registration.gross
    assert (error.station, error.target) == ("S005", name)
    assert error.kind is GrossKind.MISNAMED
    assert 0.2 < error.size_mm / 1000 < 60
    places, _ = pose_errors(registration.poses, simulated)
    assert np.abs(places).max() < 0.0015
