"""Points are found again where the same spot of the cable really is, and lost rather than mistaken."""

import cv2
import numpy as np
import pytest

from pipeline.cable.sheets import Filmed, normalise
from pipeline.cable.tracking import Tracker, TrackOptions
from pipeline.core.axis import AxisCurve
from pipeline.core.vocabulary import Poses
from tests.cable import scene

HOME = 4
ROUGH_RADIUS_M = 0.0545  # what is known of the cable beforehand: half a millimetre off
Y_AXIS = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 1)))


def tracker(read, poses=None, azimuth_deg=0.0, lens=None, **choices):
    filmed = Filmed(
        read=read,
        lens=lens or scene.lens(scene.BARREL),
        poses=poses or scene.poses(),  # the POS knows nothing of the sway
        azimuth_deg=azimuth_deg,
        axis=Y_AXIS,
        radius_m=ROUGH_RADIUS_M,
    )
    return Tracker(filmed, TrackOptions(), **choices)


@pytest.fixture(scope="module")
def pictures(barrel_frames):
    return [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in barrel_frames.files]


@pytest.fixture(scope="module")
def track(pictures):
    return tracker(lambda k: pictures[k]).track(HOME)


def errors(track, view, frame):
    """Tracked minus true place of the surface spot that was chosen in the home frame."""
    at_home = track.frame == HOME
    spots = np.full((len(track.starts), 3), np.nan)
    spots[track.point[at_home]] = view.meet(HOME, track.pixels[at_home])
    rows = track.frame == frame
    found = track.pixels[rows] - view.project(frame, spots[track.point[rows]])
    return found[np.isfinite(found[:, 0])]


@pytest.mark.parametrize("frame", [1, 2, 3, 5, 6, 7])
def test_tracked_points_are_the_same_spots_of_the_surface(track, barrel_view, frame):
    """In the original pixels, against the independent lens; sway and radius were not known."""
    found = errors(track, barrel_view, frame)
    assert len(found) > 100
    assert 0.001 < np.median(np.linalg.norm(found, axis=1)) < 0.06
    assert np.abs(np.median(found, axis=0)).max() < 0.03
    assert np.mean(np.linalg.norm(found, axis=1) > 0.5) < 0.03


def test_points_near_the_limb_are_as_good_as_those_in_the_middle(track, barrel_view):
    """A template in the frame itself would shear there by pixels; on the unrolled cylinder it does not."""
    at_home = track.frame == HOME
    spots = np.full((len(track.starts), 3), np.nan)
    spots[track.point[at_home]] = barrel_view.meet(HOME, track.pixels[at_home])
    rows = np.flatnonzero(track.frame == HOME + 2)
    away = np.linalg.norm(
        track.pixels[rows] - barrel_view.project(HOME + 2, spots[track.point[rows]]), axis=1
    )
    turned = np.abs(np.degrees(np.arctan2(-spots[track.point[rows], 2], spots[track.point[rows], 0])))
    outside = turned > 42
    assert outside.sum() > 25
    assert np.median(away[outside]) < 0.1
    assert np.mean(away[outside] > 0.5) < 0.1


def test_no_error_adds_up_along_a_track(track, barrel_view):
    """Every frame is compared with the home frame itself: four frames on it is as good as one."""
    near, far = (np.median(np.linalg.norm(errors(track, barrel_view, HOME + n), axis=1)) for n in (1, 4))
    assert far < 3 * near


def test_a_robot_that_was_faster_than_believed_does_not_lose_its_points(pictures, barrel_view):
    """Steps believed to be 12 mm instead of 20: what was learnt in one frame helps to find the next."""
    believed = scene.poses()
    centres = believed.centres * [1, 0.6, 1]
    centres[:, 1] += HOME * scene.STEP_M * 0.4
    slow = Poses(
        rotations=believed.rotations,
        translations=-np.einsum("nij,nj->ni", believed.rotations, centres),
    )
    found = tracker(lambda k: pictures[k], poses=slow).track(HOME)
    for frame, most in ((HOME - 3, 40), (HOME + 3, 40)):
        assert len(errors(found, barrel_view, frame)) > most
        assert np.median(np.linalg.norm(errors(found, barrel_view, frame), axis=1)) < 0.1


def test_points_lie_on_the_home_frame_s_own_stretch_of_the_cable_inside_the_limb(track):
    limb = np.deg2rad(TrackOptions().limb_deg)
    assert np.abs(np.arctan2(-track.starts[:, 2], track.starts[:, 0])).max() < limb
    assert np.abs(track.starts[:, 1] - HOME * scene.STEP_M).max() <= scene.STEP_M / 2 + 0.001
    np.testing.assert_allclose(np.hypot(track.starts[:, 0], track.starts[:, 2]), ROUGH_RADIUS_M)


def test_the_end_frames_look_further_along_the_cable_than_the_others(pictures):
    follow = tracker(lambda k: pictures[k])
    first, last = follow.track(0), follow.track(scene.FRAMES - 1)
    assert first.starts[:, 1].min() < -0.05
    assert first.starts[:, 1].max() < scene.STEP_M / 2 + 0.001
    assert last.starts[:, 1].min() > scene.TRAVEL_M - scene.STEP_M / 2 - 0.001
    assert last.starts[:, 1].max() > scene.TRAVEL_M + 0.05


def test_a_camera_anywhere_around_the_cable_tracks_as_well():
    view = scene.Scene(poses=scene.poses(azimuth_deg=200.0, frames=6), lens=scene.lens(scene.BARREL))
    pictures = [view.picture(k)[..., 2] for k in range(6)]
    found = tracker(lambda k: pictures[k], scene.poses(200.0, frames=6), 200.0).track(HOME)
    assert np.median(np.linalg.norm(errors(found, view, 2), axis=1)) < 0.06
    assert len(errors(found, view, 2)) > 90


def test_given_places_are_followed_like_chosen_ones(pictures, barrel_view):
    follow = tracker(lambda k: pictures[k])
    azimuth, y_m = np.radians([-40.0, -10.0, 5.0, 35.0]), HOME * scene.STEP_M + np.array([0, 2, -3, 1]) / 1000
    places = follow.sheets.places(azimuth, y_m)
    surface = follow.sheets.surface(places)
    np.testing.assert_allclose(np.arctan2(-surface[:, 2], surface[:, 0]), azimuth)
    np.testing.assert_allclose(surface[:, 1], y_m)
    np.testing.assert_allclose(follow.sheets.places(azimuth - 2 * np.pi, y_m), places)
    found = follow.follow(HOME, places)
    np.testing.assert_allclose(found.starts, surface)
    assert (found.frame == HOME).sum() == 4
    for frame in (2, 6):
        assert np.linalg.norm(errors(found, barrel_view, frame), axis=1).max() < 0.3


def test_a_lamp_that_travels_with_the_robot_does_not_pull_the_points(barrel_view, track):
    column, row = np.meshgrid(np.linspace(-1, 1, scene.WIDTH_PX), np.linspace(-1, 1, scene.HEIGHT_PX))
    light = 1.1 - 0.5 * column**2 - 0.3 * row**2
    lit = [barrel_view.picture(k, light)[..., 2] for k in range(scene.FRAMES)]
    found = tracker(lambda k: lit[k]).track(HOME)
    assert len(found.frame) > 0.8 * len(track.frame)
    assert np.median(np.linalg.norm(errors(found, barrel_view, 6), axis=1)) < 0.1
    assert np.abs(np.median(errors(found, barrel_view, 6), axis=0)).max() < 0.03


def test_an_unrelated_frame_ends_the_tracks(pictures):
    view = scene.Scene(poses=scene.poses(), lens=scene.lens(scene.BARREL), texture=scene.Texture(seed=99))
    changed = [*pictures[:6], view.picture(6)[..., 2], *pictures[7:]]
    found = tracker(lambda k: changed[k]).track(HOME)
    assert (found.frame == 5).sum() > 100
    assert (found.frame >= 6).sum() <= 5


def test_a_blank_frame_gives_birth_to_no_point(pictures):
    blank = np.full_like(pictures[0], 90)
    found = tracker(lambda k: blank).track(HOME)
    assert found.starts.shape == (0, 3)
    assert len(found.frame) == len(found.point) == len(found.pixels) == 0


def test_nothing_is_measured_beyond_the_picture_s_edge(track):
    border = TrackOptions().window_px // 2
    assert (track.pixels > border).all()
    assert (track.pixels < np.array([scene.WIDTH_PX, scene.HEIGHT_PX]) - border).all()


def test_normalising_takes_out_brightness_and_contrast(pictures):
    dull = np.clip(0.6 * pictures[0].astype(float) + 30, 0, 255).astype(np.uint8)
    plain, changed = normalise(pictures[0], 9.0).astype(float), normalise(dull, 9.0).astype(float)
    cable = slice(50, 150)
    assert np.abs(plain - changed)[cable].mean() < 4
    assert 124 < plain[cable].mean() < 132
    assert 30 < plain[cable].std() < 45


def test_a_frame_is_read_once_while_it_stays_in_memory(pictures):
    def reads(keep):
        asked = []
        tracker(lambda k: asked.append(k) or pictures[k], keep=keep).track(HOME)
        return asked

    assert sorted(reads(keep=64)) == sorted(set(reads(keep=64)))
    assert len(reads(keep=1)) > len(reads(keep=64))
