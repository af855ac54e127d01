"""When rows see the light: one moment, a blurred one, rows one after another."""

import numpy as np
import pytest

from synth.motion import block_poses
from synth.shutter import exposures
from synth.spec import LensSpec, Robot, Sensor, Spec

ROBOT = Robot(travel_m=0.2, frames=11, sway_deg=0.3)  # 20 mm from frame to frame


def spec(**sensor):
    return Spec(robot=ROBOT, lens=LensSpec(height_px=600), sensor=Sensor(**sensor))


def test_a_plain_frame_is_one_exposure_of_its_moment():
    (only,) = exposures(spec())
    assert (only.shift, only.rows, only.weight) == (0.0, None, 1.0)


def test_motion_blur_spreads_over_its_path_about_the_moment():
    parts = exposures(spec(motion_blur_mm=2.0))
    shifts = [part.shift for part in parts]
    assert len(parts) == 8
    assert np.mean(shifts) == pytest.approx(0.0)
    assert max(shifts) - min(shifts) == pytest.approx(0.1 * 7 / 8)  # 2 of 20 mm, less an eighth
    assert exposures(spec(motion_blur_mm=2.0), blurred=False) == exposures(spec())


def test_a_rolling_shutter_reads_every_row_once_from_top_to_bottom():
    parts = exposures(spec(readout_share=0.24))
    assert [part.rows for part in parts] == [(first, first + 50) for first in range(0, 600, 50)]
    assert [part.weight for part in parts] == [1.0] * 12
    assert [part.shift for part in parts] == pytest.approx(np.linspace(-0.11, 0.11, 12))


def test_every_stripe_has_the_whole_of_its_own_blur():
    parts = exposures(spec(readout_share=0.24, motion_blur_mm=2.0))
    first = [part for part in parts if part.rows == (0, 50)]
    assert sum(part.weight for part in first) == 1.0
    assert np.mean([part.shift for part in first]) == pytest.approx(-0.11)
    assert len(exposures(spec(readout_share=0.24, motion_blur_mm=2.0), blurred=False)) == 12


def test_a_moving_ring_has_another_pose_for_every_stripe():
    survey = spec(readout_share=0.24)
    centres = np.array([block_poses(survey, part.shift)[0].centres[5] for part in exposures(survey)])
    steps_mm = 1000.0 * np.diff(centres[:, 1])
    assert steps_mm == pytest.approx(np.full(11, 0.02 * 20.0), abs=0.3)  # sway has its lever
    assert np.abs(np.diff(centres[:, 0])).min() > 0.0


def test_fewer_rows_than_stripes_are_read_one_by_one():
    parts = exposures(Spec(lens=LensSpec(height_px=8), sensor=Sensor(readout_share=0.5)))
    assert [part.rows for part in parts] == [(row, row + 1) for row in range(8)]
