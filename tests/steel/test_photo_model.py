"""Photos to a cloud: orientation, depth maps, targets."""

import time

import cv2
import numpy as np
import pytest

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from pipeline.core.fits import fit_similarity
from pipeline.steel.photo_dense import densify
from pipeline.steel.photo_features import features_of
from pipeline.steel.photo_records import DepthOptions, SparseOptions
from pipeline.steel.photo_sparse import orient, pictures_in
from pipeline.steel.photo_targets import find_targets
from tests.steel.photo_scene import Scene, flight

BALLS = np.array(
    [[-0.4, 0.1, 0.3, 0.06], [1.5, 0.3, 0.2, 0.06], [0.1, 1.1, 0.15, 0.06], [0.7, -0.4, 0.1, 0.06]]
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("photos")
    scene = Scene(balls=BALLS)
    for number, (centre, rotation) in enumerate(zip(*flight(), strict=True)):
        picture, _ = scene.photo(rotation, centre, seed=number)
        cv2.imwrite(str(place / f"p{number}.png"), picture)
    return place


@pytest.fixture(scope="module")
def photos(folder, tmp_path_factory):
    scratch = tmp_path_factory.mktemp("scratch") / "map"
    return orient(pictures_in(folder), 480.0, scratch, SparseOptions(features=1500), silent)


def placed(photos):
    centres, _ = flight()
    return fit_similarity(photos.poses.centres, centres)


def test_all_photos_are_oriented_and_the_focal_length_is_found(photos):
    assert len(photos.files) == 6
    assert photos.lens.focal_px == pytest.approx(500, rel=0.02)
    assert 0.01 < photos.reprojection_px < 0.5
    fit = placed(photos)
    assert np.abs(fit.residuals).max() < 0.02


def test_marks_lie_where_spots_are_counted_from_the_corner(tmp_path):
    """A quarter of a pixel off, as OpenCV's places are by default, photos of opposite headings contradict."""
    rng, fine = np.random.default_rng(5), 4
    away = []
    for number in range(12):
        spot, sigma = rng.uniform(60, 90, 2), rng.uniform(3, 7)
        rows, columns = (np.mgrid[: 150 * fine, : 150 * fine] + 0.5) / fine
        light = 30 + 200 * np.exp(-((columns - spot[0]) ** 2 + (rows - spot[1]) ** 2) / (2 * sigma**2))
        picture = cv2.resize(light, (150, 150), interpolation=cv2.INTER_AREA)
        file = tmp_path / f"{number}.png"
        cv2.imwrite(str(file), np.rint(picture).astype(np.uint8))
        (places, _), _ = features_of(file, SparseOptions(features=200))
        away.append(places[np.argmin(np.linalg.norm(places - spot, axis=1))] - spot)
    assert np.abs(np.mean(away, axis=0)).max() < 0.1


def test_orientation_is_the_same_every_time(folder, photos, tmp_path):
    again = orient(pictures_in(folder), 480.0, tmp_path / "map", SparseOptions(features=1500), silent)
    np.testing.assert_array_equal(again.poses.translations, photos.poses.translations)
    np.testing.assert_array_equal(again.points, photos.points)


def test_orientation_stops_within_two_seconds(folder, tmp_path):
    asked, late = [0.0], []

    def stop_in_the_mapping(event):
        # 6 photos and 15 pairs are done; two more events tell of the pairs' geometry, then the mapping begins
        late.extend([event] if event.done >= 21 else [])
        if len(late) == 3:
            asked[0] = time.monotonic()
            raise Cancelled

    with pytest.raises(Cancelled):
        orient(
            pictures_in(folder), 480.0, tmp_path / "map", SparseOptions(features=1500), stop_in_the_mapping
        )
    assert asked[0] > 0
    assert time.monotonic() - asked[0] < 2
    assert not (tmp_path / "map").exists()


def test_white_balls_are_found_where_they_are(photos):
    spheres = find_targets(photos, silent)
    fit = placed(photos)
    away = np.linalg.norm(fit.apply(spheres[:, :3])[:, None] - BALLS[None, :, :3], axis=2)
    found = away.min(axis=0)
    assert np.all(found < 0.02)
    radii = fit.scale * spheres[away.argmin(axis=0), 3]
    np.testing.assert_allclose(radii, 0.06, rtol=0.15)


def test_cloud_lies_on_the_surface_with_honest_sigmas(photos):
    cloud = densify(photos, DepthOptions(step_px=3, candidate_px=1.5), silent)
    fit = placed(photos)
    points, normals = fit.apply(cloud.points), cloud.normals @ fit.rotation.T
    floor = (np.abs(points[:, 2]) < 0.1) & (np.linalg.norm(points[:, :2] - [0.7, 0.55], axis=1) > 0.8)
    top = np.all((points[:, :2] > [0.4, 0.3]) & (points[:, :2] < [1.0, 0.8]), axis=1) & (points[:, 2] > 0.3)
    assert floor.sum() > 3000
    assert top.sum() > 500
    plane = np.linalg.lstsq(np.column_stack([points[floor, :2], np.ones(floor.sum())]), points[floor, 2])[0]
    off = points[floor, 2] - np.column_stack([points[floor, :2], np.ones(floor.sum())]) @ plane
    noise, sigma = 1.4826 * np.median(np.abs(off)), fit.scale * np.median(cloud.sigmas[floor])
    assert 1e-4 < noise < 5e-3
    assert noise / 3 < sigma < 3 * noise
    # beside the box and the balls as well, where windows lie on two surfaces
    assert np.mean(np.abs(off) < 2 * fit.scale * cloud.sigmas[floor]) >= 0.9
    assert np.median(points[top, 2] - np.column_stack([points[top, :2], np.ones(top.sum())]) @ plane) == (
        pytest.approx(0.5, abs=0.01)
    )
    assert np.median(normals[floor, 2]) > 0.95


def test_photos_that_do_not_overlap_are_refused(tmp_path):
    for number in range(3):
        noise = np.random.default_rng(number).integers(0, 255, (200, 300)).astype(np.uint8)
        cv2.imwrite(str(tmp_path / f"{number}.png"), cv2.GaussianBlur(noise, (0, 0), 2))
    with pytest.raises(StageError, match="do not overlap enough"):
        orient(pictures_in(tmp_path), 300.0, tmp_path / "map", SparseOptions(features=400), silent)


def test_an_empty_folder_and_a_broken_picture_are_named(tmp_path):
    with pytest.raises(StageError, match="holds 0 pictures"):
        pictures_in(tmp_path)
    for number in range(3):
        (tmp_path / f"{number}.png").write_bytes(b"no picture")
    with pytest.raises(StageError, match=r"0\.png cannot be read"):
        orient(pictures_in(tmp_path), 300.0, tmp_path / "map", SparseOptions(), silent)
