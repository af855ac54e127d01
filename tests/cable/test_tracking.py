"""Points are found again where the same spot of the cable really is, and lost rather than mistaken."""

import cv2
import numpy as np
import pytest

from pipeline.cable.tracking import NormalisedFrames, Tracker, TrackOptions, normalise
from tests.cable import scene

HOME = 4
ROUGH_RADIUS_M = 0.0545  # what is known of the cable beforehand: half a millimetre off


def tracker(read, options, frames=scene.FRAMES):
    return Tracker(
        NormalisedFrames(read, options),
        scene.lens(),
        scene.poses(frames=frames),  # the POS knows nothing of the sway
        0.0,
        ROUGH_RADIUS_M,
        options,
    )


@pytest.fixture(scope="module")
def pictures(straight_frames):
    return [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in straight_frames.files]


@pytest.fixture(scope="module")
def track(pictures):
    return tracker(lambda k: pictures[k], TrackOptions(window_px=15)).track(HOME)


def errors(track, view, frame):
    """Tracked minus true place of the surface spot that was chosen in the home frame."""
    home = track.frame == HOME
    spots = view.meet(HOME, track.pixels[home])
    rows = track.frame == frame
    return track.pixels[rows] - view.project(frame, spots[track.point[rows]])


@pytest.mark.parametrize("frame", [2, 3, 5, 6])
def test_tracked_points_are_the_same_spots_of_the_surface(track, straight_view, frame):
    found = errors(track, straight_view, frame)
    assert len(found) > 80
    assert 0.001 < np.median(np.linalg.norm(found, axis=1)) < 0.1
    assert np.abs(np.median(found, axis=0)).max() < 0.02


def test_no_error_adds_up_along_a_track(track, straight_view):
    """Every frame is compared with the home frame itself: four frames on it is no worse than perspective."""
    assert np.median(np.linalg.norm(errors(track, straight_view, HOME + 4), axis=1)) < 0.15


def test_points_lie_on_the_home_frame_s_own_strip_of_the_cable_inside_the_limb(track, straight_view):
    limb = np.deg2rad(TrackOptions().limb_deg)
    assert np.abs(np.arctan2(-track.starts[:, 2], track.starts[:, 0])).max() < limb
    assert np.abs(track.starts[:, 1] - HOME * scene.STEP_M).max() <= scene.STEP_M / 2
    np.testing.assert_allclose(np.hypot(track.starts[:, 0], track.starts[:, 2]), ROUGH_RADIUS_M)


def test_the_last_frame_looks_ahead_further_than_the_others(pictures):
    last = tracker(lambda k: pictures[k], TrackOptions()).track(scene.FRAMES - 1)
    assert last.starts[:, 1].min() > scene.TRAVEL_M - scene.STEP_M / 2 - 1e-9
    assert last.starts[:, 1].max() > scene.TRAVEL_M + 0.05


def test_a_lamp_that_travels_with_the_robot_does_not_pull_the_points(straight_view, track):
    column, row = np.meshgrid(np.linspace(-1, 1, scene.WIDTH_PX), np.linspace(-1, 1, scene.HEIGHT_PX))
    light = 1.1 - 0.5 * column**2 - 0.3 * row**2
    lit = [straight_view.picture(k, light)[..., 2] for k in range(scene.FRAMES)]
    found = tracker(lambda k: lit[k], TrackOptions(window_px=15)).track(HOME)
    assert len(found.frame) > 0.8 * len(track.frame)
    assert np.median(np.linalg.norm(errors(found, straight_view, 6), axis=1)) < 0.1
    assert np.abs(np.median(errors(found, straight_view, 6), axis=0)).max() < 0.03


def test_an_unrelated_frame_ends_the_tracks(pictures):
    stranger = scene.Scene(poses=scene.poses(), texture=scene.Texture(seed=99)).picture(6)[..., 2]
    changed = [*pictures[:6], stranger, *pictures[7:]]
    found = tracker(lambda k: changed[k], TrackOptions()).track(HOME)
    assert (found.frame == 5).sum() > 80
    assert (found.frame >= 6).sum() <= 2


def test_a_blank_frame_gives_birth_to_no_point(pictures):
    blank = np.full_like(pictures[0], 90)
    found = tracker(lambda k: blank, TrackOptions()).track(HOME)
    assert found.starts.shape == (0, 3)
    assert len(found.frame) == len(found.point) == len(found.pixels) == 0


def test_points_are_never_taken_from_beyond_the_picture_s_edge(track):
    border = 15 // 2
    assert (track.pixels > border).all()
    assert (track.pixels < np.array([scene.WIDTH_PX, scene.HEIGHT_PX]) - border).all()


def test_normalising_takes_out_brightness_and_contrast(pictures):
    dull = np.clip(0.6 * pictures[0].astype(float) + 30, 0, 255).astype(np.uint8)
    plain, changed = normalise(pictures[0], 9.0).astype(float), normalise(dull, 9.0).astype(float)
    cable = slice(50, 150)
    assert np.abs(plain - changed)[cable].mean() < 4
    assert 124 < plain[cable].mean() < 132
    assert 30 < plain[cable].std() < 45


def test_only_the_latest_frames_stay_in_memory(pictures):
    asked = []

    def read(frame):
        asked.append(frame)
        return pictures[frame]

    frames = NormalisedFrames(read, TrackOptions(), keep=3)
    for frame in (0, 1, 2, 0, 3, 0, 1):
        assert frames[frame].shape == pictures[0].shape
    assert asked == [0, 1, 2, 3, 1]  # 0 was used again in time, 1 was not
