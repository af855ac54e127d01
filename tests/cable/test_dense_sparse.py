"""A clean sheath with a speck here and there: broad windows fill what narrow ones cannot measure."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.dense import DenseOptions
from tests.cable import scene
from tests.cable.swept import error_mm, sweep


@pytest.fixture(scope="module")
def sparse_maps(barrel_view, barrel_orientation, tmp_path_factory):
    """The map of the clean sheath with broad windows, as they come, and without; with noise."""
    folder = tmp_path_factory.mktemp("specks")
    frames = replace(barrel_view, texture=scene.Specks()).write(folder)
    rng = np.random.default_rng(1)
    for file in frames.files:
        picture = cv2.imread(str(file)).astype(float)
        picture += rng.normal(0, 2.0, picture.shape)
        cv2.imwrite(str(file), np.clip(np.rint(picture), 0, 255).astype(np.uint8))
    return [
        sweep(frames, barrel_orientation, folder, options)
        for options in (DenseOptions(), DenseOptions(broad_below=0.0))
    ]


def test_where_texture_is_sparse_broad_windows_fill_what_narrow_ones_leave_open(sparse_maps):
    broad, narrow = sparse_maps
    assert 0.2 < narrow.coverage < 0.65
    assert broad.coverage > 0.95
    assert broad.coverage == pytest.approx(np.isfinite(broad.radius_m).mean())


def test_what_broad_windows_fill_is_right(sparse_maps):
    """Narrow windows that agree by chance are far off; few of those are left."""
    broad, narrow = (np.abs(error_mm(found)) for found in sparse_maps)
    assert 0.03 < np.nanpercentile(broad, 90) < 0.15
    assert np.nanpercentile(narrow, 90) > 0.3


def test_thin_texture_biases_nothing_not_even_at_the_sides(sparse_maps):
    """Windows that held more and more of the picture as the radius shrank left the sides 0.2 mm off."""
    error = error_mm(sparse_maps[0])
    assert abs(np.nanmedian(error)) < 0.02
    for part in np.array_split(error, 5, axis=1):
        assert abs(np.nanmedian(part)) < 0.06


def test_the_window_told_is_that_of_the_cells_that_stand(sparse_maps):
    """Noise is alike over it: 9 cells of 0.61 mm, or mostly 70 of them."""
    broad, narrow = sparse_maps
    assert narrow.window_mm == pytest.approx(9 * narrow.ground_sample_mm)
    assert 0.6 * 70 * broad.ground_sample_mm < broad.window_mm < 70 * broad.ground_sample_mm
