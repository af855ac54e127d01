"""The limb of a cable that was scanned from one side is left out, wherever the scanner stood."""

import numpy as np
import pytest

from pipeline.core.rotations import rotation_from_vector
from pipeline.scan.limb import FARTHEST_DEG, off_limb
from pipeline.scan.tube import FoundCable

RADIUS, BEAM_M = 0.055, 0.0004
ROTATION = rotation_from_vector(np.array([0.4, -1.1, 0.7]))
CABLE = FoundCable(
    place=np.array([1.0, 2.0, 3.0]), direction=ROTATION[:, 1], radius_m=RADIUS, first_m=-0.3, last_m=0.3
)


def seen(azimuth_deg, seed, away_m=1.5, noise_m=0.0005):
    """(n, 3) points of a scan from this azimuth, (n,) angles from the middle, (n,) heights over the cable."""
    rng = np.random.default_rng(seed)
    # even across the width, as rays are; those nearer to the limb than a beam's radius are half behind
    across = rng.uniform(-1, 1, 40_000) * (RADIUS + BEAM_M)
    inside = np.minimum(np.abs(across) / RADIUS, 1.0)
    depth = RADIUS * np.sqrt(1 - inside**2)
    grazing = np.abs(across) > RADIUS - BEAM_M
    # what is behind lengthens the range, up to where nothing is left of the cable
    depth = (
        depth - noise_m * rng.normal(size=len(across)) - np.where(grazing, 0.003 * rng.random(len(across)), 0)
    )
    along = rng.uniform(-0.3, 0.3, len(across))
    turn = np.radians(azimuth_deg)
    x, z = depth * np.cos(turn) - across * np.sin(turn), depth * np.sin(turn) + across * np.cos(turn)
    points = np.column_stack([x, along, z]) @ ROTATION.T + CABLE.place
    return points, np.degrees(np.arctan2(across, depth)), np.hypot(x, z) - RADIUS


@pytest.mark.parametrize("azimuth_deg", [0.0, 100.0, 179.0, -91.0])
def test_what_is_left_of_one_side_is_neither_wider_nor_narrower(azimuth_deg):
    points, aside_deg, height = seen(azimuth_deg, 1)
    kept = off_limb(points, CABLE)
    assert height[np.abs(aside_deg) > 86].mean() > 0.00003
    assert abs(height[kept].mean()) < 0.00001
    assert np.abs(aside_deg[kept]).max() < FARTHEST_DEG + 2
    assert np.abs(aside_deg[~kept]).min() > FARTHEST_DEG - 2


def test_a_scan_that_lacks_part_of_its_side_loses_its_limb_all_the_same():
    points, aside_deg, _ = seen(30.0, 2)
    part = aside_deg < 40
    kept = off_limb(points[part], CABLE)
    assert not kept[aside_deg[part] < -80].any()
    assert kept[np.abs(aside_deg[part]) < 70].all()


def test_scans_from_several_sides_in_one_file_are_left_alone():
    several = np.concatenate([seen(azimuth, 3)[0] for azimuth in (0.0, 120.0, 240.0)])
    assert off_limb(several, CABLE).all()


def test_no_points_are_no_points():
    assert off_limb(np.zeros((0, 3)), CABLE).shape == (0,)
