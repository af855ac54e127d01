"""The true lens in numbers worked out by hand, in every unit of lambda."""

import numpy as np
import pytest

from pipeline.core.vocabulary import LambdaRadius, Lens
from synth.lens import block_lenses, lambda_per_focal, max_distorted_radius, project, rays
from synth.spec import LensSpec, Spec


def lens(unit, value, width=800, height=600):
    return Lens(
        width_px=width,
        height_px=height,
        focal_px=1000.0,
        principal_point_px=(400.0, 300.0),
        division_lambda=value,
        lambda_radius=unit,
    )


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        (LambdaRadius.HALF_DIAGONAL, -0.04),  # half the diagonal of 800 x 600 is 500 px
        (LambdaRadius.HALF_WIDTH, -0.0256),  # 400 px
        (LambdaRadius.FOCAL, -0.16),  # 1000 px
        (LambdaRadius.PIXEL, -1.6e-7),
    ],
)
def test_the_corner_ray_is_the_same_in_every_unit_of_lambda(unit, value):
    # the corner lies at (-400, -300) px, radius 500 px: the divisor is 1 - 0.04 = 0.96
    assert rays(lens(unit, value), np.array([0.0, 0.0])) == pytest.approx([-0.4 / 0.96, -0.3 / 0.96, 1.0])
    assert lambda_per_focal(lens(unit, value)) == pytest.approx(-0.16)


@pytest.mark.parametrize("value", [-0.2, -0.02, 0.0, 0.05])
def test_projection_undoes_the_rays(value):
    pixels = np.stack(np.meshgrid(np.linspace(0, 800, 9), np.linspace(0, 600, 7)), axis=-1)
    camera = lens(LambdaRadius.HALF_DIAGONAL, value)
    assert project(camera, 0.37 * rays(camera, pixels)) == pytest.approx(pixels, abs=1e-8)


def test_a_lens_that_folds_within_the_image_is_seen():
    assert max_distorted_radius(LensSpec(division_lambda=-0.5)) == pytest.approx(1.0)
    assert max_distorted_radius(LensSpec(division_lambda=-1.01)) is None
    assert max_distorted_radius(LensSpec(division_lambda=1.01)) is None


def test_focal_spread_has_its_standard_deviation_and_repeats_for_a_seed():
    spec = Spec(seed=3, lens=LensSpec(focal_px=700.0, focal_spread_percent=1.0))
    focals = [one.focal_px for one in block_lenses(spec)]
    assert focals == [one.focal_px for one in block_lenses(spec)]
    many = [
        f for seed in range(200) for f in (x.focal_px for x in block_lenses(Spec(seed=seed, lens=spec.lens)))
    ]
    assert np.std(many) == pytest.approx(7.0, rel=0.1)
    assert np.mean(many) == pytest.approx(700.0, abs=1.0)
