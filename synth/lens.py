"""The true lens, from the spec only: pixels to rays and points to pixels by the one-parameter division model.

Equation (15) of the cable paper: undistorted = distorted / (1 + lambda r_d^2), about the principal point.
Written anew here, so that the pipeline's lens is judged by an independent hand.
"""

import math

import numpy as np

from pipeline.core.vocabulary import Array, LambdaRadius, Lens
from synth.spec import LensSpec, Spec


def block_lenses(spec: Spec) -> tuple[Lens, ...]:
    """The true lens of every block; cameras differ only by the focal spread."""
    lens = spec.lens
    rng = np.random.default_rng([spec.seed, 31])
    factors = 1.0 + lens.focal_spread_percent / 100.0 * rng.standard_normal(len(spec.blocks))
    return tuple(
        Lens(
            width_px=lens.width_px,
            height_px=lens.height_px,
            focal_px=lens.focal_px * float(factor),
            principal_point_px=principal_point(lens),
            division_lambda=lens.division_lambda,
            lambda_radius=lens.lambda_radius,
        )
        for factor in factors
    )


def principal_point(lens: LensSpec) -> tuple[float, float]:
    """Principal point in pixels from the top-left corner, the image centre by default."""
    return lens.principal_point_px or (lens.width_px / 2.0, lens.height_px / 2.0)


def unit_px(lens: Lens | LensSpec) -> float:
    """Length in pixels of the unit in which lambda's radius is measured."""
    match lens.lambda_radius:
        case LambdaRadius.HALF_DIAGONAL:
            return math.hypot(lens.width_px, lens.height_px) / 2.0
        case LambdaRadius.HALF_WIDTH:
            return lens.width_px / 2.0
        case LambdaRadius.FOCAL:
            return lens.focal_px
        case LambdaRadius.PIXEL:
            return 1.0


def lambda_per_focal(lens: Lens) -> float:
    """Lambda for a radius measured in focal lengths, dimensionless."""
    return lens.division_lambda * (lens.focal_px / unit_px(lens)) ** 2


def rays(lens: Lens, pixels: Array) -> Array:
    """Viewing directions of pixels.

    Args:
        lens: a lens.
        pixels: (..., 2) image points, (0, 0) the top-left corner.

    Returns:
        (..., 3) directions in the camera frame, scaled to z = 1.
    """
    normal = (np.asarray(pixels, float) - lens.principal_point_px) / lens.focal_px
    divisor = 1.0 + lambda_per_focal(lens) * np.sum(normal**2, axis=-1, keepdims=True)
    return np.concatenate([normal / divisor, np.ones_like(divisor)], axis=-1)


def project(lens: Lens, points_in_cam: Array) -> Array:
    """Image points of points in front of the camera.

    Solves lambda u r^2 - r + u = 0 for the distorted radius r, in the form that also holds at lambda = 0.

    Args:
        lens: a lens.
        points_in_cam: (..., 3), camera frame, z > 0.

    Returns:
        (..., 2) pixels; NaN where the lens sees no such direction.
    """
    points = np.asarray(points_in_cam, float)
    normal = points[..., :2] / points[..., 2:]
    u2 = np.sum(normal**2, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(1.0 - 4.0 * lambda_per_focal(lens) * u2)
    return np.asarray(normal * (2.0 / (1.0 + root)) * lens.focal_px + lens.principal_point_px, float)


def max_distorted_radius(lens: LensSpec) -> float | None:
    """Largest image radius in lambda's unit, or None if the lens folds before it.

    r / (1 + lambda r^2) has its pole at lambda r^2 = -1 and turns back at lambda r^2 = 1.
    """
    cx, cy = principal_point(lens)
    far_x, far_y = max(cx, lens.width_px - cx), max(cy, lens.height_px - cy)
    radius = math.hypot(far_x, far_y) / unit_px(lens)
    return radius if abs(lens.division_lambda) * radius**2 < 1.0 else None
