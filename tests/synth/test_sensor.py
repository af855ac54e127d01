"""The sensor: known light gives known grey values, noise has its stated size, corners fall off as told."""

import numpy as np
import pytest

from pipeline.core.vocabulary import Lens
from synth.sensor import develop, falloff
from synth.spec import Sensor

LENS = Lens(
    width_px=200, height_px=120, focal_px=100.0, principal_point_px=(100.0, 60.0), division_lambda=0.0
)
CLEAN = Sensor(full_well_e=0.0, vignetting=0.0)


def flat(value):
    return np.full((120, 200, 3), value)


def test_mid_grey_light_becomes_the_srgb_value():
    # the sRGB standard puts grey value 128 at 0.21586 linear
    assert np.unique(develop(flat(0.21586), LENS, CLEAN, (1,))).tolist() == [128]
    assert np.unique(develop(flat(7.0), LENS, CLEAN, (1,))).tolist() == [255]


def test_exposure_scales_the_light():
    twice = develop(flat(0.1), LENS, Sensor(full_well_e=0.0, vignetting=0.0, exposure=2.0), (1,))
    assert np.array_equal(twice, develop(flat(0.2), LENS, CLEAN, (1,)))


def test_noise_is_photon_and_read_noise_together():
    sensor = Sensor(full_well_e=10000.0, read_noise_e=30.0, vignetting=0.0)
    grey = develop(flat(0.4), LENS, sensor, (1, 2)).astype(float) / 255.0
    linear = ((grey + 0.055) / 1.055) ** 2.4
    expected = np.sqrt(0.4 * 10000.0 + 30.0**2) / 10000.0
    assert linear.std() == pytest.approx(expected, rel=0.05)
    assert linear.mean() == pytest.approx(0.4, abs=0.001)


def test_noise_repeats_for_a_seed_only():
    sensor = Sensor()
    one, same, other = (develop(flat(0.3), LENS, sensor, (1, frame)) for frame in (0, 0, 1))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_vignetting_takes_its_share_at_half_the_diagonal():
    fall = falloff(LENS, 0.3)
    assert fall.max() == pytest.approx(1.0, abs=1e-4)
    assert fall[0, 0] == pytest.approx(0.7, abs=0.005)
    assert fall[0, 0] == pytest.approx(fall[-1, -1])
