"""Registering networks with known truth: accuracy, honest sigmas, gross errors by name, bad input."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.core import store
from pipeline.core.events import silent
from pipeline.steel.chained import compare_chained
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.register import register
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.registration_records import Registration
from pipeline.steel.survey_records import ControlTarget
from tests.steel.simulated_network import ARCSEC, point, pose_errors, simulate, survey_of


def registered(simulated, found=None, **options):
    return register(simulated.survey, found or simulated.found, RegisterOptions(**options), silent)


@pytest.mark.parametrize("levelled", [True, False])
def test_errors_are_as_large_as_the_sigmas_say(levelled):
    standardised, inside = [], []
    for seed in range(6):
        simulated = simulate(12, seed, levelled=levelled)
        found = registered(simulated)
        places, turns = pose_errors(found.poses, simulated)
        sigmas = np.array([np.sqrt(np.diag(pose.covariance)) for pose in found.poses])
        z = np.concatenate([turns, places], axis=1)[1:] / sigmas[1:]
        standardised.append(z)
        inside.append(np.abs(z) < 2)
        assert not found.gross
    assert 0.7 < np.sqrt(np.mean(np.square(standardised))) < 1.25
    assert np.mean(inside) > 0.9


def test_stations_know_how_alike_their_errors_are():
    """Neighbours far from the base err together: their difference is far better known than either place."""
    standardised, shares = [], []
    for seed in range(40):
        simulated = simulate(12, seed)
        poses = registered(simulated).poses
        np.testing.assert_allclose(poses[-1].among[-2], poses[-2].among[-1].T, atol=1e-15)
        np.testing.assert_allclose(poses[-1].among[-1], poses[-1].covariance, atol=1e-18)
        far, near = poses[-1], poses[-2]
        apart = (far.translation - near.translation) - (
            simulated.translations[-1] - simulated.translations[-2]
        )
        alone = far.covariance[3:, 3:] + near.covariance[3:, 3:]
        together = far.among[-2][3:, 3:]
        variance = np.diag(alone - together - together.T)
        standardised.append(apart**2 / variance)
        shares.append(variance / np.diag(alone))
    assert 0.7 < np.mean(standardised) < 1.4
    assert np.median(shares) < 0.8


def test_the_base_is_the_frame_and_features_come_out_in_it():
    simulated = simulate(8, 3)
    found = registered(simulated)
    base = found.pose("S001")
    assert np.array_equal(base.rotation, np.eye(3))
    assert not base.translation.any()
    assert not base.covariance.any()
    z = [
        np.linalg.solve(np.linalg.cholesky(f.covariance), f.place - simulated.targets[f.name])
        for f in found.features
    ]
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.4
    assert sum(len(one.features) for one in simulated.found) == sum(found.seen_by)


def test_the_accuracy_is_found_where_the_survey_states_it_wrongly():
    simulated = simulate(12, 1, sigma_m=0.002, stated_sigma_m=0.0007)
    (component,) = registered(simulated).components
    assert component.factor == pytest.approx(0.002 / 0.0007, rel=0.1)


def test_control_targets_define_the_frame():
    simulated = simulate(6, 7)
    turn = Rotation.from_rotvec([0.0, 0, 1.0]).as_matrix()
    seen = sorted({f.name for f in simulated.found[0].features})[:4]
    control = [
        ControlTarget(
            name=name, position_m=tuple(turn @ simulated.targets[name] + [100, 50, 3]), sigma_mm=0.5
        )
        for name in seen
    ]
    survey = survey_of([s.name for s in simulated.survey.stations], control=control)
    result = register(survey, simulated.found, RegisterOptions(), silent)
    for pose, R, t in zip(result.poses, simulated.rotations, simulated.translations, strict=True):
        sigma = np.sqrt(np.diag(pose.covariance))
        assert (sigma > 0).all()
        assert (np.abs(pose.translation - (turn @ t + [100, 50, 3])) < 4 * sigma[3:]).all()
        assert np.linalg.norm(Rotation.from_matrix(pose.rotation @ (turn @ R).T).as_rotvec()) < 0.01


def test_two_levelled_stations_with_two_common_targets_hold_together():
    simulated = simulate(2, 0, levelled=True, nearest=8)
    common = {f.name for f in simulated.found[0].features} & {f.name for f in simulated.found[1].features}
    two = sorted(common)[:2]
    found = [
        replace(one, features=tuple(f for f in one.features if f.name in two)) for one in simulated.found
    ]
    result = registered(simulated, found)
    errors, _ = pose_errors(result.poses, simulated)
    assert np.linalg.norm(errors[1]) < 4 * np.sqrt(np.trace(result.poses[1].covariance[3:, 3:])) < 0.1


def test_axes_and_planes_tie_stations_that_share_too_few_targets():
    simulated = simulate(2, 1, levelled=True, sigma_m=0.001)
    points, lines = shared_points_and_axes(simulated, targets=2)
    alone = register(simulated.survey, points, RegisterOptions(), silent)
    tied = register(simulated.survey, lines, RegisterOptions(), silent)
    assert {c.kind for c in tied.components} == {"point", "line", "plane", "plumb"}
    before, after = (np.sqrt(np.diag(r.poses[1].covariance)) for r in (alone, tied))
    assert after[2] < 0.7 * before[2]  # the heading
    assert np.hypot(*after[3:5]) < 0.85 * np.hypot(*before[3:5])
    errors, turns = pose_errors(tied.poses, simulated)
    assert (np.abs(np.concatenate([turns[1], errors[1]])) < 4 * after).all()


def shared_points_and_axes(simulated, targets):
    """Two stations' common targets, and the same with two columns and a wall that both see."""
    rng = np.random.default_rng(5)
    common = sorted(
        {f.name for f in simulated.found[0].features} & {f.name for f in simulated.found[1].features}
    )[:targets]
    points = [
        replace(one, features=tuple(f for f in one.features if f.name in common)) for one in simulated.found
    ]
    up = simulated.rotations[0] @ np.array([0.0, 0, 1])
    wall = np.array([0.6, 0.8, 0.0])
    figures = [
        (FeatureKind.LINE, "C1", np.array([6.0, 2, 1]), up),
        (FeatureKind.LINE, "C2", np.array([-5.0, 9, 1]), up),
        (FeatureKind.PLANE, "W1", np.array([12.0, 0, 1]), wall),
    ]
    tied = [
        StationFeatures(
            station=one.station,
            features=one.features + tuple(figure(*f, R, t, rng) for f in figures),
        )
        for one, R, t in zip(points, simulated.rotations, simulated.translations, strict=True)
    ]
    return points, tied


def figure(kind, name, place, direction, R, t, rng):
    """An axis or a plane as a station sees it: sigma 1 mm and 20 arc seconds, anywhere along it."""
    size = 4 if kind is FeatureKind.LINE else 3
    offsets = size - 2
    sigmas = np.array([0.001] * offsets + [20 * ARCSEC] * 2)
    noise = rng.normal(size=size) * sigmas
    local, axis = R.T @ (place - t), R.T @ direction
    u = np.cross(axis, [0.3, 0.2, 0.9])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    seen = axis + noise[-2] * u + noise[-1] * v
    seen /= np.linalg.norm(seen)
    push = noise[0] * u + noise[1] * v + rng.uniform(-1, 1) * axis if offsets == 2 else noise[0] * axis
    u = u - seen * (seen @ u)
    u /= np.linalg.norm(u)
    return Feature(
        kind=kind,
        name=name,
        place=local + push,
        direction=seen,
        frame=np.array([u, np.cross(seen, u), seen]),
        covariance=np.diag(sigmas**2),
        radius_m=0.1,
        points=100,
        rms_m=0.002,
    )


def test_the_result_can_be_stored(tmp_path):
    result = registered(simulate(4, 0))
    store.save(result, tmp_path / "r.npz", tmp_path)
    again = store.load(Registration, tmp_path / "r.npz", tmp_path)
    assert again.residuals == result.residuals
    assert np.array_equal(again.pose("S003").covariance, result.pose("S003").covariance)


def test_chaining_drifts_where_the_adjustment_of_a_ring_does_not():
    simulated = ring_of_stations(30)
    result = registered(simulated)
    chained = compare_chained(simulated.survey, simulated.found, result, silent)
    adjusted_errors, _ = pose_errors(result.poses, simulated)
    chained_errors, _ = pose_errors(chained.poses, simulated)
    far = [link.position > 10 for link in sorted(chained.links, key=lambda link: link.station)]
    rms = [np.sqrt(np.mean(np.sum(e[far] ** 2, axis=1))) for e in (adjusted_errors, chained_errors)]
    assert 2 * rms[0] < rms[1]
    last = max(chained.links, key=lambda link: link.position)
    assert last.chained_sigma_mm > 2 * last.adjusted_sigma_mm
    z = chained_errors[1:] / [np.sqrt(np.diag(pose.covariance)[3:]) for pose in chained.poses[1:]]
    assert 0.3 < np.sqrt(np.mean(z**2)) < 2.0


def ring_of_stations(count):
    """Levelled stations around a circle, each sharing targets with the next two."""
    rng = np.random.default_rng(6)
    angles = np.arange(count) * 2 * np.pi / count
    centres = np.column_stack([60 * np.cos(angles), 60 * np.sin(angles), np.zeros(count)])
    between = (np.arange(2 * count) + 0.25) * np.pi / count
    radius = 60 + np.where(np.arange(2 * count) % 2, 7, -7)
    targets = np.column_stack(
        [radius * np.cos(between), radius * np.sin(between), rng.uniform(-1, 3, 2 * count)]
    )
    simulated = simulate(count, 0, levelled=True)
    found, turns = [], simulated.rotations
    for s, name in enumerate(station.name for station in simulated.survey.stations):
        near = [(2 * s + k) % (2 * count) for k in range(-4, 4)]
        places = (targets[near] - centres[s]) @ turns[s] + rng.normal(scale=0.002, size=(8, 3))
        seen = tuple(point(f"T{n:03d}", p, 0.002) for n, p in zip(near, places, strict=True))
        found.append(StationFeatures(station=name, features=seen))
    translations = (centres - centres[0]) @ turns[0]
    return replace(
        simulated, found=found, rotations=turns[0].T @ turns, translations=translations, targets={}
    )
