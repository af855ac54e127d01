"""The ring's motion: poses by hand, lever arms, RMS as promised, ends of the travel known."""

import numpy as np
import pytest

from pipeline.core.vocabulary import TravelDirection
from synth.motion import block_poses, ring_motion
from synth.spec import Robot, Spec

SWAYING = Robot(sway_deg=0.2, sway_mm=0.5, speed_wander_mm=0.5, travel_m=0.46, frames=24)


def test_the_camera_at_90_degrees_stands_below_the_cable_and_looks_up():
    poses = block_poses(Spec(robot=Robot(travel_m=0.2, frames=3)))[1]
    assert poses.centres == pytest.approx(
        np.array([[0, 0.0, -0.3], [0, 0.1, -0.3], [0, 0.2, -0.3]]), abs=1e-12
    )
    x, y, z = poses.rotations[0]
    assert x == pytest.approx([0, 1, 0], abs=1e-12)  # travel runs to the right
    assert z == pytest.approx([0, 0, 1], abs=1e-12)
    assert y == pytest.approx([-1, 0, 0], abs=1e-12)  # z cross x


@pytest.mark.parametrize(
    ("direction", "axis", "sign"),
    [
        (TravelDirection.RIGHT, 0, 1),
        (TravelDirection.LEFT, 0, -1),
        (TravelDirection.DOWN, 1, 1),
        (TravelDirection.UP, 1, -1),
    ],
)
def test_travel_runs_in_the_stated_image_direction(direction, axis, sign):
    for poses in block_poses(Spec(robot=Robot(travel_in_image=direction))):
        rotation = poses.rotations[0]
        assert rotation @ [0, 1, 0] == pytest.approx(sign * np.eye(3)[axis], abs=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        to_axis = rotation @ (-poses.centres[0] * [1, 0, 1])
        assert to_axis == pytest.approx([0, 0, 0.3], abs=1e-12)


def test_the_travel_between_first_and_last_frame_is_exact_and_the_speed_wanders_between():
    _, origin = ring_motion(Spec(seed=5, robot=SWAYING), np.linspace(0, 1, 24))
    wander_mm = 1000.0 * (origin[:, 1] - np.linspace(0, 0.46, 24))
    assert origin[[0, -1], 1] == pytest.approx([0.0, 0.46], abs=1e-12)
    assert np.sqrt(np.mean(wander_mm**2)) == pytest.approx(0.5, abs=1e-9)
    assert np.abs(np.diff(wander_mm)).max() < 0.7  # smooth from frame to frame


def test_sway_has_its_rms_in_every_component_and_is_smooth():
    rotation, origin = ring_motion(Spec(seed=5, robot=SWAYING), np.linspace(0, 1, 24))
    vee = np.stack([rotation[:, 2, 1], rotation[:, 0, 2], rotation[:, 1, 0]], axis=1)
    assert np.degrees(np.sqrt(np.mean(vee**2, axis=0))) == pytest.approx([0.2] * 3, rel=0.02)
    lateral_mm = 1000.0 * origin[:, [0, 2]]
    assert np.sqrt(np.mean(lateral_mm**2, axis=0)) == pytest.approx([0.5, 0.5], abs=1e-9)
    assert np.abs(np.diff(lateral_mm, axis=0)).max() < 1.0


def test_opposite_cameras_are_moved_oppositely_along_the_cable_by_the_lever_arm():
    spec = Spec(seed=5, robot=SWAYING)
    centres = [poses.centres for poses in block_poses(spec)]
    rotation, origin = ring_motion(spec, np.linspace(0, 1, 24))
    lever_mm = 1000.0 * (centres[0] - origin)[:, 1]
    assert lever_mm == pytest.approx(-1000.0 * (centres[2] - origin)[:, 1], abs=1e-9)
    assert lever_mm == pytest.approx(300.0 * rotation[:, 1, 0], abs=1e-9)
    assert 0.5 < np.abs(lever_mm).max() < 5.0


def test_without_a_common_clock_every_camera_has_a_motion_of_its_own():
    for synchronised in (True, False):
        spec = Spec(robot=Robot(sway_mm=0.5, synchronised=synchronised))
        x = [poses.centres[:, 0] for poses in block_poses(spec)]
        assert np.allclose(x[1], x[3]) == synchronised


def test_mounting_errors_are_constant_over_the_frames():
    poses = block_poses(Spec(robot=Robot(mounting_deg=0.3, mounting_mm=0.5)))[2]
    nominal = block_poses(Spec(robot=Robot()))[2]
    turned = np.einsum("nij,nkj->nik", poses.rotations, nominal.rotations)
    assert turned == pytest.approx(np.broadcast_to(turned[0], turned.shape), abs=1e-12)
    assert 0.05 < np.degrees(np.arccos((np.trace(turned[0]) - 1) / 2)) < 1.5
    shift_mm = 1000.0 * (poses.centres - nominal.centres)
    assert np.ptp(shift_mm, axis=0).max() < 1e-9
    assert 0.1 < np.linalg.norm(shift_mm[0]) < 2.5


def test_motion_repeats_for_a_seed_and_differs_between_seeds():
    one, same, other = (block_poses(Spec(seed=s, robot=SWAYING))[0].centres for s in (1, 1, 2))
    assert np.array_equal(one, same)
    assert np.abs(one - other).max() > 1e-4
