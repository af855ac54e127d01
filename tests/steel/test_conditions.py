"""The observation equations vanish at the truth and their derivatives are those of finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.steel import conditions
from pipeline.steel.network import Network
from pipeline.steel.records import Feature, FeatureKind
from pipeline.steel.state import Component, Group, State, linearise

STEP = 1e-6


def frame_about(direction, rng):
    """Rows u, v, direction."""
    d = direction / np.linalg.norm(direction)
    u = np.cross(d, rng.normal(size=3))
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(d, u), d])


@pytest.fixture
def scene():
    """One station, one feature of each kind, seen without noise but in frames of its own."""
    rng = np.random.default_rng(4)
    R, t = Rotation.random(random_state=1).as_matrix(), np.array([4.0, -2.0, 1.0])
    kinds = (FeatureKind.POINT, FeatureKind.LINE, FeatureKind.PLANE)
    places = rng.normal(scale=5, size=(3, 3))
    frames = np.array([np.eye(3), frame_about(rng.normal(size=3), rng), frame_about(rng.normal(size=3), rng)])
    along = [np.zeros(3), 0.7 * frames[1, 2], 0.4 * frames[2, 0] - 0.3 * frames[2, 1]]
    seen = tuple(
        Feature(
            kind=kind,
            name="F",
            place=R.T @ (place + slide - t),
            direction=R.T @ frame[2],
            # either sign is right for an axis or a normal
            frame=np.eye(3) if kind is FeatureKind.POINT else frame_about(-R.T @ frame[2], rng),
            covariance=np.eye(4 if kind is FeatureKind.LINE else 3),
            radius_m=0.0,
            points=0,
            rms_m=0.0,
        )
        for kind, place, slide, frame in zip(kinds, places, along, frames, strict=True)
    )
    network = Network(
        stations=("S1",),
        base=0,
        names=("F", "F", "F"),
        kinds=kinds,
        station=np.zeros(3, dtype=np.int64),
        feature=np.arange(3),
        seen=seen,
        control={},
    )
    plumb = frame_about(R @ [0.0, 0, 1], rng)
    return network, State(rotations=R[None], translations=t[None], places=places, frames=frames, plumb=plumb)


def group_of(component):
    number = {"point": 0, "line": 1, "plane": 2, "plumb": 3}[component.value]
    return Group(
        component=component,
        station=np.array([0]),
        feature=np.array([number]),
        observation=np.array([min(number, 2)]),
        cofactor=np.eye(3)[None],
    )


KINDS = [Component.POINT, Component.LINE, Component.PLANE, Component.PLUMB]


@pytest.mark.parametrize("component", KINDS)
def test_residuals_vanish_at_the_truth(scene, component):
    network, state = scene
    assert np.abs(linearise(network, group_of(component), state).residuals).max() < 1e-12


@pytest.mark.parametrize("component", KINDS)
def test_derivatives_are_those_of_finite_differences(scene, component):
    network, state = scene
    group = group_of(component)
    # off the truth, so that the second factors of products count
    rng = np.random.default_rng(8)
    state = state.moved(0.02 * rng.normal(size=(1, 6)), 0.02 * rng.normal(size=(4, 4)), network.kinds)
    linear = linearise(network, group, state)

    def computed(station, feature):
        moved = state.moved(station, feature, network.kinds)
        return -linearise(network, group, moved).residuals[0]

    for analytic, which in ((linear.by_station[0], 0), (linear.by_feature[0], 1)):
        for column in range(analytic.shape[1]):
            steps = [np.zeros((1, 6)), np.zeros((4, 4))]
            row = 0 if which == 0 else int(group.feature[0])
            steps[which][row, column] = STEP
            numeric = (computed(*steps) - computed(*(-s for s in steps))) / (2 * STEP)
            assert np.abs(analytic[:, column] - numeric).max() < 1e-6


def test_a_frame_leans_by_the_slopes_given():
    rng = np.random.default_rng(2)
    frame = frame_about(rng.normal(size=3), rng)
    leaned = conditions.moved_frame(frame[None], np.array([[0.03, -0.2]]))[0]
    assert np.allclose(leaned @ leaned.T, np.eye(3))
    wanted = frame[2] + 0.03 * frame[0] - 0.2 * frame[1]
    assert np.allclose(leaned[2], wanted / np.linalg.norm(wanted))


def test_a_moved_observation_shows_as_its_own_residual(scene):
    network, state = scene
    pushed = replace(network.seen[0], place=network.seen[0].place + np.array([0.05, 0, 0]))
    network = replace(network, seen=(pushed, *network.seen[1:]))
    assert np.allclose(linearise(network, group_of(Component.POINT), state).residuals[0], [0.05, 0, 0])
