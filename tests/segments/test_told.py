"""What a segment tells of the whole lies at the whole's places and azimuths."""

import numpy as np
import pytest

from pipeline.segments.told import told
from pipeline.segments.traverse import Placement
from tests.report import sample

START_M, ROLL_DEG = 10.0, 30.0
PLACED = Placement(
    scale=1.0,
    scale_sigma=1e-5,
    start_m=START_M,
    from_m=START_M,
    to_m=START_M + 0.3,
    roll=np.radians(ROLL_DEG),
    link_ppm=0.0,
)


@pytest.fixture(scope="module")
def data():
    return sample.report_data()


@pytest.fixture(scope="module")
def found(data):
    return told(data, np.eye(3), PLACED, last=False)


def test_what_stands_out_turns_and_moves_and_is_told_by_one_segment(found):
    """The dent lies beyond the hand-over."""
    assert [f.kind for f in found.features] == ["ridge", "bulge"]
    assert [f.position_m for f in found.features] == pytest.approx([10.23, 10.145])
    assert [f.azimuth_deg for f in found.features] == pytest.approx([168.2 + ROLL_DEG - 360, 20.1 + ROLL_DEG])


def test_a_station_turns_with_its_section(data, found):
    for own, whole in zip(data.stations, found.stations, strict=True):
        assert whole.position_m == own.position_m + START_M
        for mine, moved in (
            (own.section_mm, whole.section_mm),
            (np.array([own.circle_centre_mm]), np.array([whole.circle_centre_mm])),
        ):
            turned_deg = np.degrees(
                np.arctan2(-moved[:, 1], moved[:, 0]) - np.arctan2(-mine[:, 1], mine[:, 0])
            )
            np.testing.assert_allclose(turned_deg % 360, ROLL_DEG)
            np.testing.assert_allclose(np.hypot(*moved.T), np.hypot(*mine.T))


def test_the_profile_ends_where_the_next_segment_begins(found):
    assert found.profile.position_m.min() == pytest.approx(START_M + 0.02)
    assert START_M + 0.29 < found.profile.position_m.max() < PLACED.to_m
