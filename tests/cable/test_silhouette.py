"""The cable's outline in drawn pictures whose edges are known."""

import numpy as np
import pytest

from pipeline.cable.silhouette import cable_mask, find_silhouette, mask_between
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import TravelDirection
from tests.cable.outline_pictures import picture_of_cable

RIGHT, DOWN = TravelDirection.RIGHT, TravelDirection.DOWN


def upper(x):
    return 165.3 + 0.006 * x + 2e-6 * (x - 480) ** 2


def lower(x):
    return 436.8 - 0.004 * x - 3e-6 * (x - 480) ** 2


def rms(points, curve):
    return np.sqrt(np.mean((points[:, 1] - curve(points[:, 0])) ** 2))


def spread(points, curve):
    """Standard deviation by the median, for edges of which a few per cent may be deceived by dirt."""
    return 1.4826 * np.median(np.abs(points[:, 1] - curve(points[:, 0])))


@pytest.mark.parametrize(
    ("sky", "bound_px"),
    [((185, 170, 160), 0.25), ((60, 60, 60), 0.25), ((140, 120, 105), 0.25), ((90, 90, 90), 0.45)],
)
def test_edges_are_found_to_a_fraction_of_a_pixel_before_any_sky(sky, bound_px):
    """Bright, dark, as bright as the cable but bluer, and a grey contrast of 2.5 times the texture."""
    found = find_silhouette(picture_of_cable(upper, lower, sky=sky), RIGHT)
    for points, curve in ((found.first, upper), (found.second, lower)):
        assert len(points) > 100
        assert 0.02 < spread(points, curve) < bound_px
        assert abs(np.median(points[:, 1] - curve(points[:, 0]))) < 0.12


def test_strong_streaks_on_the_cable_are_not_its_edge():
    picture = picture_of_cable(upper, lower)
    picture[250:254] = 20
    picture[330:333, 100:800] = 240
    found = find_silhouette(picture, RIGHT)
    assert rms(found.first, upper) < 0.2
    assert rms(found.second, lower) < 0.2


def test_a_wire_in_the_sky_is_passed_over_when_the_width_is_roughly_known():
    picture = picture_of_cable(upper, lower)
    picture[60:66] = 30
    outermost = find_silhouette(picture, RIGHT)
    assert outermost.first[:, 1].mean() < 70
    known = find_silhouette(picture, RIGHT, expected_width_px=250.0)
    assert rms(known.first, upper) < 0.2
    assert rms(known.second, lower) < 0.2


def test_cable_that_runs_down_the_picture():
    picture = picture_of_cable(upper, lower).transpose(1, 0, 2).copy()
    found = find_silhouette(picture, DOWN)
    assert rms(found.first[:, ::-1], upper) < 0.2
    assert rms(found.second[:, ::-1], lower) < 0.2
    mask = mask_between(found, 600, 960)
    assert mask.shape == (960, 600)
    assert mask[480, 300] == 255
    assert mask[480, 100] == mask[480, 500] == 0


def test_mask_is_the_cable_less_its_inset():
    picture = picture_of_cable(upper, lower)
    x, y = np.arange(960) + 0.5, np.arange(600)[:, None] + 0.5
    for inset in (0.0, 12.0):
        truth = (y > upper(x) + inset) & (y < lower(x) - inset)
        assert np.mean((cable_mask(picture, RIGHT, inset) > 0) != truth) < 1e-3


@pytest.mark.parametrize("kind", ["sky", "noise", "cable fills the picture", "one edge"])
def test_a_picture_without_both_edges_is_refused_by_name(kind):
    far = 1e6
    pictures = {
        "sky": lambda: picture_of_cable(lambda x: x + far, lambda x: x + far),
        "noise": lambda: np.random.default_rng(0).integers(0, 255, (600, 960, 3)).astype(np.uint8),
        "cable fills the picture": lambda: picture_of_cable(lambda x: x - far, lambda x: x + far, texture=25),
        "one edge": lambda: picture_of_cable(upper, lambda x: x + far),
    }
    with pytest.raises(StageError, match="Block3, frame 17 shows no cable"):
        find_silhouette(pictures[kind](), RIGHT, name="Block3, frame 17")
