"""The unrolled picture is the cable's own texture, in place and in its colours, whatever lit it."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.surface import SurfaceOptions, build_surface
from pipeline.cable.texture import TextureOptions, texture_block
from tests.cable import scene

BLUE, GREEN, RED = 0, 1, 2


@pytest.fixture(scope="module")
def surface(barrel_map):
    return build_surface(barrel_map, SurfaceOptions())


def unroll(frames, orientation, surface, emit=scene.silent, **options):
    return texture_block(frames, orientation, surface, 0.6125, TextureOptions(**options), emit)


@pytest.fixture(scope="module")
def picture(barrel_frames, barrel_orientation, surface):
    return unroll(barrel_frames, barrel_orientation, surface, even_exposure=False)


def truth(picture, view, turn=0.0, rise=0.0):
    """The cable's brightness at every texel, or ``turn`` and ``rise`` texels beside it."""
    azimuth = picture.azimuth + turn * np.diff(picture.azimuth).mean()
    y_m = picture.y_m + rise * np.diff(picture.y_m).mean()
    return view.texture(*np.meshgrid(azimuth, y_m))


def likeness(picture, view, **beside):
    known = picture.known
    return np.corrcoef(picture.colour[..., RED][known], truth(picture, view, **beside)[known])[0, 1]


def peak(left, middle, right):
    """Where a parabola through three neighbours peaks, in texels."""
    return (left - right) / (2 * (left - 2 * middle + right))


def test_the_unrolled_picture_is_the_texture(picture, barrel_view):
    assert likeness(picture, barrel_view) > 0.95
    inner = picture.known & (np.abs(picture.azimuth) < 0.7)
    difference = (picture.colour[..., RED] - truth(picture, barrel_view))[inner]
    assert abs(difference.mean()) < 1.0
    assert 0.3 < difference.std() < 3  # of a texture of 28


def test_it_lies_in_place_to_a_part_of_a_texel(picture, barrel_view):
    middle = likeness(picture, barrel_view)
    around = [likeness(picture, barrel_view, turn=t) for t in (-1, 1)]
    along = [likeness(picture, barrel_view, rise=r) for r in (-1, 1)]
    assert abs(peak(around[0], middle, around[1])) < 0.1
    assert abs(peak(along[0], middle, along[1])) < 0.1


def test_colours_keep_their_order(picture, barrel_view):
    inner = picture.known & (truth(picture, barrel_view) > 60)
    mean = picture.colour[inner].astype(float).mean(axis=0)
    np.testing.assert_allclose(mean / mean[RED], scene.TINT, rtol=0.01)


def test_texels_have_the_size_they_say(picture):
    assert picture.texel_mm == pytest.approx(0.75 * 0.6125)
    np.testing.assert_allclose(1000 * np.diff(picture.y_m), picture.texel_mm)
    np.testing.assert_allclose(55 * np.diff(picture.azimuth), picture.texel_mm, rtol=1e-3)
    assert picture.colour.shape == (len(picture.y_m), len(picture.azimuth), 3)


def test_nearly_all_of_the_surface_is_pictured_and_the_rest_is_black(picture):
    assert 0.95 < picture.known.mean() <= 1
    assert (picture.colour[~picture.known] == 0).all()


def test_a_hole_in_the_surface_is_a_hole_in_the_picture(barrel_frames, barrel_orientation, surface):
    radius = surface.radius_m.copy()
    radius[180:220, 80:120] = np.nan
    picture = unroll(barrel_frames, barrel_orientation, replace(surface, radius_m=radius))
    row = np.searchsorted(picture.y_m, surface.y_m[200])
    column = np.searchsorted(picture.azimuth, surface.azimuth[100])
    assert not picture.known[row, column]
    assert (picture.colour[row, column] == 0).all()
    assert picture.known[row, column + 60]


def vignetting(strength=0.5):
    """Darker towards the corners, and a lamp at one side of the cable."""
    column, row = np.meshgrid(np.linspace(-1, 1, scene.WIDTH_PX), np.linspace(-1, 1, scene.HEIGHT_PX))
    return 1.1 - strength * (0.5 * column**2 + 0.5 * row**2) + 0.3 * strength * row


def unevenness(picture, view):
    """Standard deviation of the brightness against truth, in patches of some 10 mm, relative."""
    known = picture.known
    ratio = np.where(known, picture.colour[..., RED] / np.maximum(truth(picture, view), 30), np.nan)
    patches = [np.nanmean(p) for r in np.array_split(ratio, 12) for p in np.array_split(r, 9, axis=1)]
    return np.std(patches) / np.mean(patches)


@pytest.fixture(scope="module")
def unevenly_lit(barrel_view, tmp_path_factory):
    return barrel_view.write(tmp_path_factory.mktemp("lit"), vignetting())


def test_what_lamp_and_lens_add_is_divided_out(unevenly_lit, barrel_orientation, surface, barrel_view):
    raw, even = (
        unroll(unevenly_lit, barrel_orientation, surface, even_exposure=choice) for choice in (False, True)
    )
    assert unevenness(raw, barrel_view) > 0.05
    assert unevenness(even, barrel_view) < 0.5 * unevenness(raw, barrel_view)
    assert likeness(even, barrel_view) > likeness(raw, barrel_view)
    assert likeness(even, barrel_view) > 0.93


def test_even_light_is_left_alone(barrel_frames, barrel_orientation, surface, picture, barrel_view):
    even = unroll(barrel_frames, barrel_orientation, surface, even_exposure=True)
    assert likeness(even, barrel_view) > likeness(picture, barrel_view) - 0.02
    ratio = even.colour[even.known].mean() / picture.colour[picture.known].mean()
    assert ratio == pytest.approx(1, abs=0.03)


def test_seams_between_frames_do_not_show(unevenly_lit, barrel_orientation, surface, barrel_view):
    """Along the cable, brightness against truth must not jump where the next frame takes over."""
    even = unroll(unevenly_lit, barrel_orientation, surface)
    middle = slice(len(even.azimuth) // 3, -len(even.azimuth) // 3)
    ratio = (even.colour[..., RED] / np.maximum(truth(even, barrel_view), 30))[:, middle].mean(axis=1)
    inside = ratio[(even.y_m > 0) & (even.y_m < scene.TRAVEL_M)]
    assert np.abs(np.diff(inside)).max() < 0.03


def test_progress_is_told_frame_by_frame(barrel_frames, barrel_orientation, surface):
    events = []
    unroll(barrel_frames, barrel_orientation, surface, emit=events.append, texel_mm=2.0)
    assert [(e.stage, e.block, e.done, e.total) for e in events] == [
        ("texture", "Block1", k, scene.FRAMES) for k in range(scene.FRAMES)
    ]
