"""Marks on the line between two cameras are found in both, and belong to one point of the surface."""

import numpy as np
import pytest

from pipeline.cable.closing import ClosingBlock, ClosingOptions, find_shared_marks
from pipeline.cable.tracking import TrackOptions
from pipeline.cable.unrolled_match import UnrolledMatchOptions
from tests.cable import scene

OPTIONS = ClosingOptions(
    cell_mm=0.5,
    match=UnrolledMatchOptions(points=200, patch_mm=9.0, search_mm=3.0, agreement_mm=0.6, round_trip_mm=0.2),
    track=TrackOptions(window_px=15, limb_deg=62.0),
)


def closing_block(folder, azimuth_deg, texture):
    view = scene.Scene(poses=scene.poses(azimuth_deg), texture=texture)
    frames = view.write(folder)
    orientation = scene.true_orientation(view)
    turn = np.radians(azimuth_deg + np.random.default_rng(1).uniform(-50, 50, len(orientation.points)))
    points = view.points(turn, orientation.points[:, 1])
    orientation = orientation.__class__(**{**vars(orientation), "points": points})
    return view, ClosingBlock(frames=frames, orientation=orientation, azimuth_deg=azimuth_deg)


@pytest.fixture(scope="module")
def neighbours(tmp_path_factory):
    folder, texture = tmp_path_factory.mktemp("closing"), scene.Texture(seed=3)
    return [closing_block(folder / str(a), a, texture) for a in (0.0, 90.0)]


@pytest.fixture(scope="module")
def found(neighbours):
    return find_shared_marks(tuple(b for _, b in neighbours), OPTIONS, scene.silent)


def test_neighbours_share_marks_on_the_line_between_them(found):
    assert len(found.points) > 20
    azimuth = np.degrees(np.arctan2(-found.points[:, 2], found.points[:, 0]))
    assert 25 < azimuth.min() < azimuth.max() < 65
    assert (found.pairs == [0, 1]).all()


def test_every_mark_is_followed_on_both_sides(found):
    for block in (0, 1):
        views = np.bincount(found.mark[found.block == block], minlength=len(found.points))
        assert views.min() >= 3


def test_all_measurements_of_a_mark_meet_at_one_point_of_the_true_surface(found, neighbours):
    """Each pixel is carried to the true surface by the test's own ray: the spread is the matching's error."""
    spots = np.empty((len(found.pixels), 3))
    for block, (view, _) in enumerate(neighbours):
        for frame in np.unique(found.frame[found.block == block]):
            mine = (found.block == block) & (found.frame == frame)
            spots[mine] = view.meet(int(frame), found.pixels[mine])
    middle = np.stack([np.median(spots[found.mark == m], axis=0) for m in range(len(found.points))])
    away_mm = 1000 * np.linalg.norm(spots - middle[found.mark], axis=1)
    assert 0.001 < np.median(away_mm) < 0.12  # a pixel is 0.6 mm square on, 1 mm at this angle
    sides = [
        np.stack([np.median(spots[(found.mark == m) & (found.block == b)], axis=0) for b in (0, 1)])
        for m in range(len(found.points))
    ]
    offset_mm = 1000 * np.mean([s[0] - s[1] for s in sides], axis=0)
    assert np.abs(offset_mm).max() < 0.06


def test_cameras_with_different_surfaces_share_nothing(neighbours, tmp_path):
    _, other = closing_block(tmp_path / "other", 90.0, scene.Texture(seed=44))
    found = find_shared_marks((neighbours[0][1], other), OPTIONS, scene.silent)
    assert len(found.points) < 5


def test_cameras_that_do_not_see_a_common_strip_share_nothing(neighbours, tmp_path):
    _, opposite = closing_block(tmp_path / "opposite", 180.0, scene.Texture(seed=3))
    found = find_shared_marks((neighbours[0][1], opposite), OPTIONS, scene.silent)
    assert len(found.points) == 0
    assert found.pixels.shape == (0, 2)
