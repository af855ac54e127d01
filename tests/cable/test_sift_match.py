"""Two pictures tell how far apart along the cable they were taken, or that they cannot tell."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.sift_match import CableView, Marks, SiftOptions, find_marks, find_shift, mutual_matches
from pipeline.core.vocabulary import TravelDirection
from tests.cable import scene

OPTIONS = SiftOptions()
VIEW = CableView(
    lens=scene.lens(scene.BARREL),
    travel_in_image=TravelDirection.RIGHT,
    standoff_m=scene.STANDOFF_M,
    radius_m=scene.RADIUS_M,
)
STEADY = scene.Scene(poses=scene.poses(), lens=scene.lens(scene.BARREL))


def grey(view, frame):
    return cv2.cvtColor(view.picture(frame), cv2.COLOR_BGR2GRAY)


def marks_of(picture, view=VIEW):
    return find_marks(picture, view, view.mask(OPTIONS.limb_deg), OPTIONS)


@pytest.fixture(scope="module")
def marks():
    return {k: marks_of(grey(STEADY, k)) for k in (0, 2, 6)}


def test_places_on_the_cylinder_agree_with_the_independent_camera():
    pixels = np.random.default_rng(1).uniform([0, 0], [scene.WIDTH_PX, scene.HEIGHT_PX], (500, 2))
    points, places = STEADY.meet(0, pixels), VIEW.places(pixels)
    seen = np.isfinite(points[:, 0])
    assert 100 < seen.sum() < 450
    assert np.isnan(places[~seen]).any(axis=1).all()
    arc = scene.RADIUS_M * np.arctan2(-points[seen, 2], points[seen, 0])
    np.testing.assert_allclose(places[seen], np.stack([arc, points[seen, 1]], axis=1), atol=1e-9)


@pytest.mark.parametrize("travel", list(TravelDirection))
def test_along_grows_towards_where_the_travel_points(travel):
    towards = {"right": (1, 0), "left": (-1, 0), "up": (0, -1), "down": (0, 1)}[travel.value]
    places = replace(VIEW, travel_in_image=travel).places(scene.MIDDLE_PX + 20.0 * np.array([towards]))
    assert 0.01 < places[0, 1] < 0.02
    assert abs(places[0, 0]) < 1e-9


def test_marks_lie_on_the_cable_and_not_on_what_is_behind_it():
    noise = np.random.default_rng(2).integers(0, 255, (scene.HEIGHT_PX, scene.WIDTH_PX), dtype=np.uint8)
    found = marks_of(cv2.GaussianBlur(noise, (0, 0), 1.5))
    assert len(found.places) > 100
    assert np.abs(found.places[:, 0]).max() < scene.RADIUS_M * np.radians(OPTIONS.limb_deg) + 1e-3


@pytest.mark.parametrize(("first", "second"), [(0, 2), (2, 6), (6, 0)])
def test_the_shift_is_the_way_between_the_two(marks, first, second):
    shift = find_shift(marks[first], marks[second], scene.STANDOFF_M, OPTIONS)
    assert shift.marks > 40
    assert abs(shift.along_m - scene.STEP_M * (second - first)) < 1e-4


def test_a_lamp_that_travels_with_the_camera_does_not_decide(marks):
    lamp = np.linspace(0.4, 1.3, scene.WIDTH_PX)[None, :] * np.ones((scene.HEIGHT_PX, 1))
    lit = cv2.cvtColor(STEADY.picture(2, lamp), cv2.COLOR_BGR2GRAY)
    shift = find_shift(marks[0], marks_of(lit), scene.STANDOFF_M, OPTIONS)
    assert abs(shift.along_m - 2 * scene.STEP_M) < 5e-4


def test_another_cable_gives_no_shift(marks):
    other = replace(STEADY, texture=scene.Texture(seed=9))
    assert find_shift(marks[0], marks_of(grey(other, 2)), scene.STANDOFF_M, OPTIONS) is None


def test_a_picture_without_marks_gives_no_shift(marks):
    plain = marks_of(np.full((scene.HEIGHT_PX, scene.WIDTH_PX), 90, dtype=np.uint8))
    assert len(plain.places) == 0
    assert find_shift(marks[0], plain, scene.STANDOFF_M, OPTIONS) is None


def test_a_pattern_that_repeats_gives_no_shift():
    """Twenty marks seen again 30 mm further on: either shift is as good as the other."""
    rng = np.random.default_rng(3)
    raw = rng.normal(size=(40, 128)).astype(np.float32)
    descriptors = raw / np.linalg.norm(raw, axis=1, keepdims=True)
    places = rng.uniform(-0.03, 0.03, (40, 2))
    moved = places - [0, 0.05]
    moved[20:, 1] += 0.03
    first, second = (Marks(places=p, descriptors=descriptors) for p in (places, moved))
    assert find_shift(first, second, scene.STANDOFF_M, OPTIONS) is None
    whole = Marks(places=places - [0, 0.05], descriptors=descriptors)
    found = find_shift(first, whole, scene.STANDOFF_M, OPTIONS)
    assert (found.marks, round(found.along_m, 9)) == (40, 0.05)


def test_marks_are_compared_in_their_band_around_the_cable_only():
    """Round specks look alike: what tells them apart is how far around the cable they sit."""
    alike = np.ones((3, 128), dtype=np.float32) / np.sqrt(128)
    arcs = np.array([[-0.03, 0.0], [0.0, 0.0], [0.03, 0.0]])
    one, other = Marks(places=arcs, descriptors=alike), Marks(places=arcs[::-1] + 1e-3, descriptors=alike)
    a, b = mutual_matches(one, other, 0.009, 0.95)
    assert (a.tolist(), b.tolist()) == ([0, 1, 2], [2, 1, 0])
    a, b = mutual_matches(one, other, 1.0, 0.95)
    assert len(a) == 0
