"""The one-parameter division lens: pixels to rays and back, both in closed form.

Takes a :class:`~pipeline.core.vocabulary.Lens` and points; gives rays, pixels, derivatives and remap tables.
Leaves out how a lens is found (``pipeline/cable/lens.py``).

Source: paper, equations (12) to (15), with only lambda kept; A. W. Fitzgibbon, "Simultaneous linear
estimation of multiple view geometry and lens distortion", CVPR 2001.  Written for coordinates divided by the
focal length it reads u = d / (1 + k |d|^2), k = lambda (f / r_unit)^2, which is COLMAP's SIMPLE_DIVISION.

*Rays* are undistorted normalised image coordinates (x/z, y/z).  *Parameters* are (f, cx, cy, k): three in
pixels, k without unit.  *Unknowns* of an adjustment are (f, cx, cy, q), q the same bend in units of the
picture.  Pixel (0, 0) is the top-left corner of the image.
"""

from dataclasses import replace
from math import hypot, isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array, LambdaRadius, Lens

BEND_UNIT_PX = 1000.0
"""Unit of the radius that the adjusted coefficient q belongs to: some value that keeps it near 1."""

LARGEST_CANVAS = 1.6
"""The undistorted canvas is at most this many times as wide and as high as the image."""


def radius_unit_px(lens: Lens) -> float:
    """Pixels in one unit of the radius that lambda belongs to."""
    match lens.lambda_radius:
        case LambdaRadius.HALF_DIAGONAL:
            return hypot(lens.width_px, lens.height_px) / 2
        case LambdaRadius.HALF_WIDTH:
            return lens.width_px / 2
        case LambdaRadius.FOCAL:
            return lens.focal_px
        case LambdaRadius.PIXEL:
            return 1.0


def coefficient(lens: Lens) -> float:
    """k of the lens: lambda for coordinates divided by the focal length, k = lambda (f / r_unit)^2."""
    return lens.division_lambda * (lens.focal_px / radius_unit_px(lens)) ** 2


def parameters(lens: Lens) -> Array:
    """(f, cx, cy, k) of the lens, (4,): what an adjustment works on and COLMAP calls SIMPLE_DIVISION."""
    return np.array([lens.focal_px, *lens.principal_point_px, coefficient(lens)])


def with_parameters(lens: Lens, values: ArrayLike) -> Lens:
    """Give the lens other (f, cx, cy, k), keeping its image size and its unit of lambda."""
    focal, cx, cy, k = (float(value) for value in np.asarray(values))
    bare = replace(lens, focal_px=focal, principal_point_px=(cx, cy))
    return replace(bare, division_lambda=k * (radius_unit_px(bare) / focal) ** 2)


def unknowns(lens: Lens) -> Array:
    """(f, cx, cy, q) of the lens, (4,): what an adjustment looks for.

    q = k (BEND_UNIT_PX / f)^2 is the bend of lines in the picture.  Unlike k it is the same whatever the
    focal length is, so what plumb lines tell of it may be a prior beside a focal length that is 5 % off.
    """
    return parameters(lens) * np.array([1, 1, 1, (BEND_UNIT_PX / lens.focal_px) ** 2])


def with_unknowns(lens: Lens, values: ArrayLike) -> Lens:
    """Give the lens other (f, cx, cy, q), keeping its image size and its unit of lambda."""
    focal, cx, cy, q = (float(value) for value in np.asarray(values))
    return with_parameters(lens, (focal, cx, cy, q * (focal / BEND_UNIT_PX) ** 2))


def bend_per_lambda(lens: Lens) -> float:
    """What q changes by when lambda does."""
    return (BEND_UNIT_PX / radius_unit_px(lens)) ** 2


def pixels_to_rays(lens: Lens, points_px: ArrayLike) -> Array:
    """Undistort: (n, 2) pixels to (n, 2) rays, equation (15); NaN beyond the fold of the lens."""
    distorted = (np.asarray(points_px, dtype=float) - lens.principal_point_px) / lens.focal_px
    k_r2 = coefficient(lens) * np.sum(distorted**2, axis=-1, keepdims=True)
    return distorted / np.where(np.abs(k_r2) < 1, 1 + k_r2, np.nan)


def rays_to_pixels(lens: Lens, rays: ArrayLike) -> Array:
    """Distort: (n, 2) rays to (n, 2) pixels; NaN where no pixel sees the ray.

    The root of k u d^2 - d + u = 0 that goes to u for k -> 0, in the form without cancellation.
    """
    undistorted = np.asarray(rays, dtype=float)
    scale = _stretch(coefficient(lens), np.sum(undistorted**2, axis=-1, keepdims=True))[1]
    return lens.focal_px * scale * undistorted + lens.principal_point_px


def project(lens: Lens, points_in_cam: ArrayLike) -> Array:
    """Project (n, 3) points in the camera's frame to (n, 2) pixels; NaN behind it or beyond the fold."""
    points = np.asarray(points_in_cam, dtype=float)
    depth = np.where(points[..., 2:] > 0, points[..., 2:], np.nan)
    return rays_to_pixels(lens, points[..., :2] / depth)


def project_with_jacobian(lens_unknowns: ArrayLike, points_in_cam: ArrayLike) -> tuple[Array, Array, Array]:
    """Project with analytic derivatives, for adjustments.

    Args:
        lens_unknowns: (4,) or (n, 4), (f, cx, cy, q).
        points_in_cam: (n, 3), in front of the camera.

    Returns:
        pixels (n, 2), d pixels / d point (n, 2, 3), d pixels / d (f, cx, cy, q) (n, 2, 4); all laid out
        with the n last, as whoever goes on computing wants them.
    """
    points = np.asarray(points_in_cam, dtype=float)
    focal, cx, cy, q = np.moveaxis(np.broadcast_to(lens_unknowns, (len(points), 4)), -1, 0)
    per_bend = (focal / BEND_UNIT_PX) ** 2
    k = q * per_bend
    inverse_depth = 1 / np.where(points[:, 2] > 0, points[:, 2], np.nan)
    u, v = points[:, 0] * inverse_depth, points[:, 1] * inverse_depth
    rho = u * u + v * v
    root, scale = _stretch(k, rho)
    stretched = focal * scale
    # with root = sqrt(1 - 4 k rho) and scale = 2 / (1 + root): d scale = scale^2 / root (rho dk + k d rho)
    slope = focal * scale**2 / root
    bent = 2 * slope * k
    pixels = np.stack([stretched * u + cx, stretched * v + cy])
    per_point, per_lens = np.empty((3, 2, len(points))), np.empty((4, 2, len(points)))
    across = bent * u * v * inverse_depth
    per_point[0, 0], per_point[1, 1] = ((stretched + bent * w * w) * inverse_depth for w in (u, v))
    per_point[1, 0] = per_point[0, 1] = across
    per_lens[1], per_lens[2] = [[1.0], [0.0]], [[0.0], [1.0]]
    for row, w in enumerate((u, v)):
        per_point[2, row] = -(u * per_point[0, row] + v * per_point[1, row])
        per_k = slope * rho * w
        per_lens[0, row] = scale * w + 2 * k / focal * per_k
        per_lens[3, row] = per_bend * per_k
    return pixels.T, per_point.transpose(2, 1, 0), per_lens.transpose(2, 1, 0)


def check(lens: Lens) -> None:
    """Refuse a lens that folds inside its own picture.

    Barrel: the ray runs to infinity where lambda r^2 = -1; pincushion: the mapping turns back where
    lambda r^2 = +1.  Either must lie outside the farthest corner.

    Raises:
        StageError: a value is not a number, the focal length is not positive, or the lens folds.
    """
    if not all(isfinite(value) for value in parameters(lens)) or lens.focal_px <= 0:
        raise StageError(
            "lens",
            f"focal_px = {lens.focal_px:g}, division_lambda = {lens.division_lambda:g} is no lens",
            "give a positive focal length and a finite lambda",
        )
    farthest = _farthest_corner_px(lens) / radius_unit_px(lens)
    if abs(lens.division_lambda) * farthest**2 >= 1:
        raise StageError(
            "lens",
            f"division_lambda = {lens.division_lambda:g} ({lens.lambda_radius}) folds the picture before its "
            f"corner, where it must stay within ±{1 / farthest**2:.4g}",
            "give a lambda closer to zero or check lambda_radius",
        )


def undistorted_lens(lens: Lens) -> Lens:
    """The pinhole camera on whose canvas the undistorted picture is drawn.

    Same focal length; the canvas grows by whole pixels on each side until the mid-points of the four edges
    are inside, at most to 1.6 times the image; the principal point moves with it.
    """
    width, height = lens.width_px, lens.height_px
    middles = np.array([[0, height / 2], [width / 2, 0], [width, height / 2], [width / 2, height]])
    ideal = pixels_to_rays(lens, middles) * lens.focal_px + lens.principal_point_px
    outward = np.array([-ideal[0, 0], -ideal[1, 1], ideal[2, 0] - width, ideal[3, 1] - height])
    room = (LARGEST_CANVAS - 1) / 2 * np.array([width, height, width, height])
    # a middle beyond the fold has no place at all (NaN): take all the room there is
    left, top, right, bottom = np.ceil(np.clip(np.nan_to_num(outward, nan=np.inf) - 1e-9, 0, np.floor(room)))
    return Lens(
        width_px=int(width + left + right),
        height_px=int(height + top + bottom),
        focal_px=lens.focal_px,
        principal_point_px=(
            lens.principal_point_px[0] + float(left),
            lens.principal_point_px[1] + float(top),
        ),
        division_lambda=0.0,
        lambda_radius=lens.lambda_radius,
        focal_sigma_px=lens.focal_sigma_px,
    )


def undistortion_maps(lens: Lens, pinhole: Lens) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Where each pixel of the pinhole canvas is found in the distorted image, for ``cv2.remap``.

    Args:
        lens: that took the image.
        pinhole: of the canvas, without distortion.

    Returns:
        map_x, map_y, each (pinhole.height_px, pinhole.width_px) float32, in OpenCV's coordinates; pixels that
        the lens never saw point far outside.
    """
    # the same as rays_to_pixels of pixels_to_rays to the last bit, but columns and rows apart: 5 times as
    # fast, which a picture that follows a slider needs
    (cx, cy), (lens_x, lens_y) = pinhole.principal_point_px, lens.principal_point_px
    x = (np.arange(pinhole.width_px) + 0.5 - cx) / pinhole.focal_px
    y = (np.arange(pinhole.height_px) + 0.5 - cy) / pinhole.focal_px
    factor = lens.focal_px * _stretch(coefficient(lens), x**2 + (y**2)[:, None])[1]
    seen = np.isfinite(factor)
    maps = []
    for offset, unit in ((lens_x, x), (lens_y, y[:, None])):
        # our origin is the corner of the first pixel, OpenCV's its centre: half a pixel between them
        pixels = factor * unit
        pixels += offset
        pixels -= 0.5
        maps.append(np.where(seen, pixels, -1e4).astype(np.float32))
    return maps[0], maps[1]


def _stretch(k: ArrayLike, rho: Array) -> tuple[Array, Array]:
    """sqrt(1 - 4 k rho) and the scale from ray to distorted ray, for rays of squared length rho."""
    inner = 1 - 4 * np.asarray(k) * rho
    root = np.sqrt(np.where(inner > 0, inner, np.nan))
    return root, 2 / (1 + root)


def _farthest_corner_px(lens: Lens) -> float:
    cx, cy = lens.principal_point_px
    return hypot(max(cx, lens.width_px - cx), max(cy, lens.height_px - cy))
