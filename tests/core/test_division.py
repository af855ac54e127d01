"""The division lens against pycolmap's SIMPLE_DIVISION, against itself, and against differences."""

import cv2
import numpy as np
import pycolmap
import pytest

from pipeline.core import division
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import LambdaRadius, Lens


def lens_of(division_lambda=-0.02, radius=LambdaRadius.HALF_DIAGONAL, **changes):
    values = {"width_px": 960, "height_px": 600, "focal_px": 720.0, "principal_point_px": (483.0, 296.5)}
    return Lens(**(values | changes), division_lambda=division_lambda, lambda_radius=radius)


def pixels_of(lens, count=200, seed=0):
    return np.random.default_rng(seed).uniform((0, 0), (lens.width_px, lens.height_px), (count, 2))


LENSES = [
    lens_of(-0.02),
    lens_of(0.03),
    lens_of(-0.3, LambdaRadius.FOCAL),
    lens_of(-0.05, LambdaRadius.HALF_WIDTH),
    lens_of(-2e-7, LambdaRadius.PIXEL),
    lens_of(0.0),
]


@pytest.mark.parametrize("lens", LENSES)
def test_agrees_with_colmap_simple_division_both_ways(lens):
    camera = pycolmap.Camera(
        model="SIMPLE_DIVISION", width=lens.width_px, height=lens.height_px, params=division.parameters(lens)
    )
    pixels = pixels_of(lens)
    rays = division.pixels_to_rays(lens, pixels)
    np.testing.assert_allclose(rays, camera.cam_from_img(pixels), atol=1e-12)
    in_cam = np.column_stack([rays, np.ones(len(rays))]) * 0.3
    np.testing.assert_allclose(division.project(lens, in_cam), camera.img_from_cam(in_cam), atol=1e-9)
    np.testing.assert_allclose(division.rays_to_pixels(lens, rays), pixels, atol=1e-9)


def test_lambda_acts_on_the_radius_in_its_own_unit():
    """Equation (15) by hand at the mid-point of the right edge: r_d = half-width, unit half-width."""
    lens = lens_of(-0.05, LambdaRadius.HALF_WIDTH, principal_point_px=(480.0, 300.0))
    ray = division.pixels_to_rays(lens, [[960.0, 300.0]])
    np.testing.assert_allclose(ray, [[480 / 0.95 / 720, 0.0]], atol=1e-14)


def test_parameters_and_back_keep_lambda_in_its_unit():
    for lens in LENSES:
        again = division.with_parameters(lens, division.parameters(lens))
        assert again.division_lambda == pytest.approx(lens.division_lambda, abs=1e-15)
        assert again.lambda_radius == lens.lambda_radius


def test_unknowns_and_back_keep_the_lens_and_its_bend_hangs_on_no_focal_length():
    for lens in LENSES:
        again = division.with_unknowns(lens, division.unknowns(lens))
        assert again.division_lambda == pytest.approx(lens.division_lambda, abs=1e-15)
    bend, other = (division.unknowns(lens_of(-0.08, focal_px=f))[3] for f in (720.0, 756.0))
    assert bend == pytest.approx(other, rel=1e-12)
    assert bend == pytest.approx(-0.08 * division.bend_per_lambda(lens_of(-0.08)), rel=1e-12)


@pytest.mark.parametrize("lens", [lens_of(-0.08), lens_of(0.05), lens_of(0.0)])
def test_derivatives_agree_with_central_differences(lens):
    rng = np.random.default_rng(3)
    points = np.column_stack([rng.uniform(-0.2, 0.2, (30, 2)), rng.uniform(0.25, 0.4, 30)])
    values = division.unknowns(lens)
    pixels, per_point, per_lens = division.project_with_jacobian(values, points)
    np.testing.assert_allclose(pixels, division.project(lens, points), atol=1e-10)

    def at(step_values, step_points):
        return division.project_with_jacobian(values + step_values, points + step_points)[0]

    for axis in range(3):
        step = np.eye(3)[axis] * 1e-6
        numeric = (at(0, step) - at(0, -step)) / 2e-6
        np.testing.assert_allclose(per_point[:, :, axis], numeric, rtol=1e-6, atol=1e-4)
    for index, size in enumerate((1e-3, 1e-3, 1e-3, 1e-6)):
        step = np.eye(4)[index] * size
        numeric = (at(step, 0) - at(-step, 0)) / (2 * size)
        np.testing.assert_allclose(per_lens[:, :, index], numeric, rtol=1e-6, atol=1e-5)


def test_one_lens_per_point_equals_one_lens_at_a_time():
    points = np.array([[0.05, 0.02, 0.3], [-0.1, 0.03, 0.25]])
    values = np.array([division.unknowns(lens_of(-0.02)), division.unknowns(lens_of(-0.1))])
    together = division.project_with_jacobian(values, points)
    for i in range(2):
        alone = division.project_with_jacobian(values[i], points[i : i + 1])
        for a, b in zip(together, alone, strict=True):
            np.testing.assert_array_equal(a[i], b[0])


def test_no_pixel_beyond_the_fold_nor_behind_the_camera():
    pincushion = lens_of(0.25, LambdaRadius.FOCAL)  # k = 0.25: rays reach at most 1 / (2 sqrt(k)) = 1
    assert np.isfinite(division.rays_to_pixels(pincushion, [[0.999, 0.0]])).all()
    assert np.isnan(division.rays_to_pixels(pincushion, [[1.001, 0.0]])).all()
    assert np.isnan(division.pixels_to_rays(pincushion, [[483.0 + 720 * 2.01, 296.5]])).all()
    assert np.isnan(division.project(lens_of(), [[0.0, 0.0, -0.3]])).all()


def test_the_fold_is_refused_exactly_from_the_corner_on():
    central = {"principal_point_px": (480.0, 300.0)}
    for sign in (-1, 1):
        division.check(lens_of(sign * 0.999, **central))
        with pytest.raises(StageError, match="folds the picture"):
            division.check(lens_of(sign * 1.001, **central))
    with pytest.raises(StageError, match="is no lens"):
        division.check(lens_of(float("nan")))
    with pytest.raises(StageError, match="positive focal"):
        division.check(lens_of(focal_px=0.0))


@pytest.mark.parametrize("division_lambda", [-0.02, -0.15, 0.04])
def test_undistorted_canvas_just_holds_the_edge_middles(division_lambda):
    lens = lens_of(division_lambda)
    pinhole = division.undistorted_lens(lens)
    middles = np.array([[0, 300.0], [960, 300], [480, 0], [480, 600]])
    on_canvas = division.rays_to_pixels(pinhole, division.pixels_to_rays(lens, middles))
    size = np.array([pinhole.width_px, pinhole.height_px])
    assert (on_canvas >= 0).all()
    assert (on_canvas <= size).all()
    if division_lambda < 0:  # less than a pixel of it is waste
        assert on_canvas[0, 0] < 1
        assert size[0] - on_canvas[1, 0] < 1
        assert on_canvas[2, 1] < 1
    else:
        assert tuple(size) == (960, 600)


def test_undistorted_canvas_is_bounded():
    pinhole = division.undistorted_lens(lens_of(-0.95, principal_point_px=(480.0, 300.0)))
    assert pinhole.width_px == 1536  # 1.6 times 960, where the edge's middle would ask for 3035
    assert (
        pinhole.height_px == 820
    )  # 300 px above the centre go to 300 / (1 - 0.95 * 300^2 / 320400) = 409.2 px


def test_remap_moves_a_picture_of_the_coordinates_to_where_they_belong():
    """A picture whose grey is its own x: after remap each pinhole pixel must hold the x it came from."""
    lens = lens_of(-0.05)
    pinhole = division.undistorted_lens(lens)
    centres_x = np.tile(np.arange(960, dtype=np.float32) + 0.5, (600, 1))
    undistorted = cv2.remap(centres_x, *division.undistortion_maps(lens, pinhole), cv2.INTER_LINEAR)
    rows, columns = np.array([100, 300, 550]), np.array([200, 500, 900])
    rays = division.pixels_to_rays(pinhole, np.column_stack([columns + 0.5, rows + 0.5]))
    expected = division.rays_to_pixels(lens, rays)[:, 0]
    np.testing.assert_allclose(undistorted[rows, columns], expected, atol=0.04)  # remap works in 1/32 px


@pytest.mark.parametrize("division_lambda", [-0.3, -0.02, 0.0, 0.3, 0.6])
def test_the_remap_tables_are_those_of_the_two_mappings_to_the_last_bit(division_lambda):
    lens = lens_of(division_lambda, principal_point_px=(471.3, 310.7))
    pinhole = division.undistorted_lens(lens)
    x, y = np.meshgrid(np.arange(pinhole.width_px) + 0.5, np.arange(pinhole.height_px) + 0.5)
    rays = division.pixels_to_rays(pinhole, np.stack([x, y], axis=-1))
    expected = np.nan_to_num(division.rays_to_pixels(lens, rays) - 0.5, nan=-1e4).astype(np.float32)
    np.testing.assert_array_equal(np.stack(division.undistortion_maps(lens, pinhole), axis=-1), expected)
    assert (expected == -1e4).any() == (division_lambda >= 0.3)
