"""Lenses against truth: focal length, lambda, and what both together do to a pixel."""

import numpy as np

from pipeline.core.division import pixels_to_rays, radius_unit_px
from pipeline.core.vocabulary import LambdaRadius, Lens
from pipeline.evaluate.documents import Document
from pipeline.evaluate.records import LensErrors

GRID = 41
"""Pixels compared along each side of the image, corners included."""


def compare_lenses(report: Document, truth: Document) -> tuple[LensErrors, ...]:
    """Compare the lens of each block of the run with the true one.

    The run's principal point is the image centre unless the report tells it.

    Raises:
        StageError: the truth does not know a block's lens.
    """
    return tuple(_compare(block, truth.inside("lenses")) for block in report.items("blocks"))


def displacement_px(lens: Lens, true: Lens) -> float:
    """Largest distance, over the image, between a pixel undistorted with the one lens and with the other.

    In pixels of the true lens; infinite where the lens folds inside the image.
    """
    x, y = np.meshgrid(np.linspace(0, true.width_px, GRID), np.linspace(0, true.height_px, GRID))
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    difference = pixels_to_rays(lens, pixels) - pixels_to_rays(true, pixels)
    distance = true.focal_px * np.linalg.norm(difference, axis=1)
    return float(np.max(np.where(np.isfinite(distance), distance, np.inf)))


def _compare(block: Document, lenses: Document) -> LensErrors:
    name = block.text("name")
    true = _lens(lenses.inside(name))
    lens = _lens(block, size_px=(true.width_px, true.height_px))
    # lambda r^2 / unit^2 says the same in any unit: bring the run's lambda to the truth's unit
    in_true_unit = lens.division_lambda * (radius_unit_px(true) / radius_unit_px(lens)) ** 2
    return LensErrors(
        block=name,
        focal_percent=100 * (lens.focal_px / true.focal_px - 1),
        lambda_error=in_true_unit - true.division_lambda,
        displacement_px=displacement_px(lens, true),
    )


def _lens(source: Document, size_px: tuple[int, int] | None = None) -> Lens:
    width, height = size_px or (round(source.number("width_px")), round(source.number("height_px")))
    centre = (width / 2, height / 2)
    if "principal_point_px" in source:
        x, y = source.array("principal_point_px", 2)
        centre = (float(x), float(y))
    radius = source.text("lambda_radius")
    if radius not in list(LambdaRadius):
        raise source.error(f"{source.where}.lambda_radius is {radius}")
    return Lens(
        width_px=width,
        height_px=height,
        focal_px=source.number("focal_px"),
        principal_point_px=centre,
        division_lambda=source.number("division_lambda"),
        lambda_radius=LambdaRadius(radius),
    )
