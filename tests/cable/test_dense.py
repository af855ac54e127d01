"""The radius map of a painted cable: right, as noisy as it says, and empty where nothing can be matched."""

from dataclasses import replace

import cv2
import numpy as np
import pycolmap
import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.dense import DenseMethod, DenseOptions
from pipeline.core.errors import StageError
from tests.cable import scene
from tests.cable.swept import error_mm, sweep


def test_the_surface_is_right(barrel_map):
    error = error_mm(barrel_map)
    assert abs(np.nanmedian(error)) < 0.02
    assert np.nanpercentile(np.abs(error), 95) < 0.35
    for part in np.array_split(error, 6, axis=0):  # along the whole way, the ends included
        assert abs(np.nanmedian(part)) < 0.05
    for part in np.array_split(error, 5, axis=1):  # and all around
        assert abs(np.nanmedian(part)) < 0.06


def test_the_noise_is_what_the_two_halves_say_it_is(barrel_map):
    scatter = 1.4826 * np.nanmedian(np.abs(error_mm(barrel_map)))
    assert 0.6 < barrel_map.noise_mm / scatter < 1.7
    assert 0.02 < barrel_map.noise_mm < 0.15


def test_most_of_what_the_camera_passed_is_covered(barrel_map):
    assert barrel_map.coverage == pytest.approx(np.isfinite(barrel_map.radius_m).mean())
    assert 0.97 < barrel_map.coverage < 1
    for part in np.array_split(np.isfinite(barrel_map.radius_m), 10, axis=0):
        assert part.mean() > 0.94  # the end frames lack partners on one side: no reason for holes there
    assert barrel_map.y_m[0] == pytest.approx(-0.025, abs=1e-3)
    assert barrel_map.y_m[-1] == pytest.approx(scene.TRAVEL_M + 0.025, abs=2e-3)
    np.testing.assert_allclose(np.rad2deg(barrel_map.azimuth[[0, -1]]), [-60, 60])


def test_a_pixel_on_the_surface_has_the_size_it_has(barrel_map):
    truth_mm = 1000 * (scene.STANDOFF_M - scene.RADIUS_M) / scene.FOCAL_PX
    assert barrel_map.ground_sample_mm == pytest.approx(truth_mm, rel=0.01)
    assert 1000 * np.diff(barrel_map.y_m).mean() == pytest.approx(barrel_map.ground_sample_mm)


def test_a_bare_patch_is_masked_and_its_surroundings_are_not(barrel_view, barrel_orientation, tmp_path):
    class Bare(scene.Texture):
        """A cable with a stretch of one even grey."""

        def __call__(self, azimuth, y_m):
            bare = (np.abs(np.angle(np.exp(1j * azimuth))) < 0.3) & (np.abs(y_m - 0.09) < 0.02)
            return np.where(bare, 128, super().__call__(azimuth, y_m))

    frames = replace(barrel_view, texture=Bare()).write(tmp_path / "bare")
    found = sweep(frames, barrel_orientation, tmp_path)
    azimuth, y_m = np.meshgrid(found.azimuth, found.y_m)
    stands = np.isfinite(found.radius_m)
    inside = (np.abs(azimuth) < 0.2) & (np.abs(y_m - 0.09) < 0.015)
    outside = (np.abs(azimuth) < 0.7) & (np.abs(y_m - 0.09) > 0.03) & (y_m > 0) & (y_m < scene.TRAVEL_M)
    assert stands[inside].mean() < 0.05
    assert stands[outside].mean() > 0.97


def test_cells_whose_two_halves_disagree_are_masked(barrel_frames, barrel_orientation, tmp_path):
    """One frame believed 0.15 mm from its place tells two radii, from before and from behind."""
    poses = barrel_orientation.poses
    translations = poses.translations.copy()
    translations[5] -= poses.rotations[5] @ [0, 0.00015, 0]
    wrong = replace(barrel_orientation, poses=replace(poses, translations=translations))
    found = sweep(barrel_frames, wrong, tmp_path)
    own_strip = np.abs(found.y_m - 5 * scene.STEP_M) < 0.007
    assert np.isfinite(found.radius_m[own_strip]).mean() < 0.15
    assert np.nanmedian(found.score[own_strip]) > 0.9  # agreement alone would not tell


def test_a_bump_stands_out_of_the_map(barrel_view, tmp_path):
    def bump(azimuth, y_m):
        around = scene.RADIUS_M * np.angle(np.exp(1j * azimuth))
        return 0.0015 * np.exp(-(around**2 + (y_m - 0.07) ** 2) / (2 * 0.01**2))

    view = replace(barrel_view, height_m=bump)
    found = sweep(view.write(tmp_path / "bump"), scene.true_orientation(view), tmp_path)
    azimuth, y_m = np.meshgrid(found.azimuth, found.y_m)
    left = error_mm(found) - 1000 * bump(azimuth, y_m)
    assert abs(np.nanmedian(left)) < 0.03
    assert 1.25 < np.nanmedian(error_mm(found)[bump(azimuth, y_m) > 0.00142]) < 1.55


def ridge(azimuth, y_m):
    """A helical rib, 2 mm high and as wide as 26 cells, as steep as 22 degrees; distance to its crest, mm."""
    around = scene.RADIUS_M * np.angle(np.exp(1j * (azimuth - (y_m - 0.09) / 0.6 * 2 * np.pi)))
    return 1000 * around


def ridge_height_m(azimuth, y_m):
    return 0.002 * np.cos(np.pi * np.clip(ridge(azimuth, y_m) / 16, -0.5, 0.5)) ** 2


@pytest.fixture(scope="module")
def ridge_map(barrel_view, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ridge")
    view = replace(barrel_view, height_m=ridge_height_m)
    return sweep(view.write(folder), scene.true_orientation(view), folder)


def test_a_ridge_has_its_height_and_its_flanks(ridge_map):
    azimuth, y_m = np.meshgrid(ridge_map.azimuth, ridge_map.y_m)
    across = ridge(azimuth, y_m)
    left = error_mm(ridge_map) - 1000 * ridge_height_m(azimuth, y_m)
    assert -0.17 < np.nanmedian(left[np.abs(across) < 1.5]) < 0.03  # the window of 5.5 mm rounds the crest
    for first, last in ((-6, -2), (2, 6)):
        flank = (across > first) & (across < last)
        assert abs(np.nanmedian(left[flank])) < 0.06
    assert abs(np.nanmedian(left[np.abs(across) > 12])) < 0.03


def test_a_ridge_is_seen_and_what_is_wrong_there_is_masked(ridge_map):
    azimuth, y_m = np.meshgrid(ridge_map.azimuth, ridge_map.y_m)
    near = (np.abs(ridge(azimuth, y_m)) < 8) & (y_m > 0) & (y_m < scene.TRAVEL_M)
    left = (error_mm(ridge_map) - 1000 * ridge_height_m(azimuth, y_m))[near]
    assert np.isfinite(left).mean() > 0.85
    assert (np.abs(left[np.isfinite(left)]) > 0.35).mean() < 0.08


def test_light_that_moves_along_with_the_camera_is_not_taken_for_the_surface(
    barrel_view, barrel_orientation, tmp_path
):
    """Bright and dark bands that stand still in the picture would pull every cell towards them."""
    bands = 1 + 0.3 * np.sin(np.arange(scene.WIDTH_PX) * 2 * np.pi / 25)
    frames = barrel_view.write(tmp_path / "bands", light=np.tile(bands, (scene.HEIGHT_PX, 1)))
    found = sweep(frames, barrel_orientation, tmp_path)
    matched = sweep(frames, barrel_orientation, tmp_path, DenseOptions(detail_cells=0.0))
    assert found.coverage > 0.75
    assert found.coverage > matched.coverage + 0.1
    assert 1.4826 * np.nanmedian(np.abs(error_mm(found))) < 0.15


def test_the_camera_may_stand_anywhere_around_the_cable(tmp_path):
    view = scene.Scene(poses=scene.poses(azimuth_deg=250.0, frames=6), lens=scene.lens(scene.BARREL))
    turn = Rotation.from_euler("y", 250, degrees=True).as_matrix()
    points = scene.cable_points(view) @ turn.T
    orientation = replace(scene.true_orientation(view), points=points)
    found = sweep(view.write(tmp_path / "f"), orientation, tmp_path, azimuth_deg=250.0)
    assert np.rad2deg(found.azimuth.mean()) == pytest.approx(250)
    assert abs(np.nanmedian(error_mm(found))) < 0.03
    assert found.coverage > 0.8


def test_coarser_cells_are_taken_when_they_are_asked_for(barrel_frames, barrel_orientation, tmp_path):
    found = sweep(barrel_frames, barrel_orientation, tmp_path, DenseOptions(cell_mm=1.5))
    np.testing.assert_allclose(np.diff(found.y_m), 0.0015)
    assert scene.RADIUS_M * np.diff(found.azimuth).mean() == pytest.approx(0.0015, rel=0.03)
    assert abs(np.nanmedian(error_mm(found))) < 0.03


def test_frames_that_do_not_belong_together_are_refused(barrel_orientation, tmp_path):
    rng = np.random.default_rng(1)
    files = [tmp_path / f"{k}.png" for k in range(scene.FRAMES)]
    for file in files:
        noise = rng.integers(0, 255, (scene.HEIGHT_PX, scene.WIDTH_PX, 3), dtype=np.uint8)
        cv2.imwrite(str(file), noise)
    with pytest.raises(StageError) as told:
        sweep(scene.sequence(files), barrel_orientation, tmp_path)
    assert str(told.value).startswith("dense: Block1: only ")
    assert str(told.value).endswith(
        "of the surface could be matched; check the focus, the lens and the stand-off of this block."
    )


def test_progress_never_goes_back_and_names_the_block(barrel_frames, barrel_orientation, tmp_path):
    events = []
    sweep(barrel_frames, barrel_orientation, tmp_path, DenseOptions(cell_mm=2.0), emit=events.append)
    shares = [e.done / e.total for e in events]
    assert shares == sorted(shares)
    assert len(events) == 3 * scene.FRAMES
    assert {(e.stage, e.block) for e in events} == {("dense", "Block1")}
    assert 0.9 < shares[-1] <= 1


@pytest.mark.skipif(pycolmap.has_cuda, reason="patch matching is there")
def test_patch_matching_without_cuda_is_refused(barrel_frames, barrel_orientation, tmp_path):
    with pytest.raises(StageError, match=r"needs a pycolmap built with CUDA.*leave dense\.method at sweep"):
        sweep(barrel_frames, barrel_orientation, tmp_path, DenseOptions(method=DenseMethod.PATCH_MATCH))
