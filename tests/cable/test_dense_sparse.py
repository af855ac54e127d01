"""A clean sheath with a speck here and there: broad windows fill what narrow ones cannot measure."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.dense import DenseOptions
from tests.cable import scene
from tests.cable.swept import error_mm, sweep


class Specks(scene.Texture):
    """A clean sheath: dark specks of about a millimetre, one in 8 x 8 mm, on even grey."""

    def __call__(self, azimuth, y_m):
        rng = np.random.default_rng(3)
        count = round(2 * np.pi * scene.RADIUS_M * 0.5 / 0.008**2)
        speck_azimuth = rng.uniform(-np.pi, np.pi, count)
        speck_y_m = rng.uniform(-0.2, 0.3, count)
        size_m, depth = rng.uniform(4e-4, 8e-4, count), rng.uniform(30, 80, count)
        grey = np.full(np.shape(azimuth), 170.0)
        for k in range(count):
            near = np.flatnonzero(np.abs(y_m - speck_y_m[k]) < 5 * size_m[k])
            turned = np.angle(np.exp(1j * (azimuth[near] - speck_azimuth[k])))
            square = (scene.RADIUS_M * turned) ** 2 + (y_m[near] - speck_y_m[k]) ** 2
            grey[near] -= depth[k] * np.exp(-square / (2 * size_m[k] ** 2))
        return np.clip(grey, 0, 255)


@pytest.fixture(scope="module")
def sparse_maps(barrel_view, barrel_orientation, tmp_path_factory):
    """The map of the clean sheath with broad windows, as they come, and without; with noise."""
    folder = tmp_path_factory.mktemp("specks")
    frames = replace(barrel_view, texture=Specks()).write(folder)
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
    assert narrow.coverage < 0.65
    assert narrow.coverage + 0.15 < broad.coverage < 0.95
    assert broad.coverage == pytest.approx(np.isfinite(broad.radius_m).mean())


def test_what_broad_windows_fill_is_right(sparse_maps):
    """Narrow windows that agree by chance are millimetres off; few of those are left."""
    broad, narrow = (np.abs(error_mm(found)) for found in sparse_maps)
    assert abs(np.nanmedian(error_mm(sparse_maps[0]))) < 0.03
    assert 0.05 < np.nanpercentile(broad, 90) < 0.45
    assert np.nanpercentile(narrow, 90) > 1.0


def test_the_window_told_is_that_of_the_cells_that_stand(sparse_maps):
    """Noise is alike over it: 9 cells of 0.61 mm, or mostly 70 of them."""
    broad, narrow = sparse_maps
    assert narrow.window_mm == pytest.approx(9 * narrow.ground_sample_mm)
    assert 0.6 * 70 * broad.ground_sample_mm < broad.window_mm < 70 * broad.ground_sample_mm
