"""An evaluation as text for the screen: the paper's Table 2, then cameras, lenses, surface, relief, axis."""

import math
from collections.abc import Sequence

from pipeline.evaluate.records import (
    AxisErrors,
    CameraComparison,
    DiameterErrors,
    Evaluation,
    LensErrors,
    ReliefErrors,
    SurfaceErrors,
)
from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.evaluate.steel.table import format_steel
from pipeline.evaluate.text import aligned, number

PAPER_MAE_MM = 1.0053
"""Mean absolute error of the paper's Table 2."""


def format_table(evaluation: Evaluation | SteelEvaluation) -> str:
    """Lay out the evaluation in aligned columns; a number that is not known is a dash."""
    if isinstance(evaluation, SteelEvaluation):
        return format_steel(evaluation)
    parts = [_diameters(evaluation)]
    if evaluation.cameras is not None:
        parts.append(_cameras(evaluation.cameras))
    if evaluation.lenses is not None:
        parts.append(_lenses(evaluation.lenses))
    if evaluation.surface is not None:
        parts.append(_surface(evaluation.surface))
    if evaluation.relief is not None:
        parts.append(_relief(evaluation.relief))
    axis = [f"Axis: straight within {number(evaluation.straightness_mm_per_m, 3)} mm per metre"]
    parts.append(axis if evaluation.axis is None else [*axis, _axis(evaluation.axis)])
    return "\n\n".join("\n".join(lines) for lines in parts) + "\n"


def _diameters(evaluation: Evaluation) -> list[str]:
    found = evaluation.diameters
    rows = [
        [
            row.name,
            number(row.position_m, 3),
            number(row.model_mm, 3),
            number(row.truth_mm, 3),
            number(row.difference_mm, 3, sign=True),
            number(row.relative_percent, 3),
            number(row.sigma_mm, 3),
            number(row.z, 1),
        ]
        for row in found.stations
    ]
    head = ["station", "at m", "model mm", "truth mm", "diff mm", "error %", "sigma mm", "z"]
    return [
        f"Diameters of {evaluation.name}",
        *aligned(head, rows),
        f"MAE {found.mean_absolute_mm:.4f} mm, largest {found.largest_mm:.3f} mm "
        f"(the paper's MAE: {PAPER_MAE_MM} mm)",
        *_bases(found),
    ]


def _bases(found: DiameterErrors) -> list[str]:
    """The bare sheath, where run and truth tell it."""
    rows = [
        [
            row.name,
            number(row.base_model_mm, 3),
            number(row.base_truth_mm, 3),
            number(row.base_difference_mm, 3, sign=True),
            number(row.base_sigma_mm, 3),
        ]
        for row in found.stations
    ]
    if math.isnan(found.base_mean_absolute_mm):
        return []
    head = ["bare sheath", "model mm", "truth mm", "diff mm", "sigma mm"]
    return [*aligned(head, rows), f"MAE of the bare sheath {found.base_mean_absolute_mm:.4f} mm"]


def _cameras(found: CameraComparison) -> list[str]:
    head = ["block", "frames", "radial mm", "around mm", "along mm", "position mm", "attitude deg"]
    lines = []
    for title, rows in (
        ("Cameras against truth as they stand (rms)", found.as_they_stand),
        (
            f"Cameras after the best rigid fit of {found.fit_translation_mm:.3f} mm and "
            f"{found.fit_rotation_deg:.4f} deg (rms)",
            found.fitted,
        ),
    ):
        table = [
            [
                row.block,
                str(row.frames),
                *(number(v, 3) for v in (row.radial_mm, row.around_mm, row.along_mm, row.position_mm)),
                number(row.attitude_deg, 4),
            ]
            for row in rows
        ]
        lines += [title, *aligned(head, table)]
    return lines


def _lenses(found: Sequence[LensErrors]) -> list[str]:
    rows = [
        [
            row.block,
            number(row.focal_percent, 3, sign=True),
            number(row.lambda_error, 5, sign=True),
            number(row.displacement_px, 3),
        ]
        for row in found
    ]
    return ["Lenses against truth", *aligned(["block", "focal %", "lambda", "largest px"], rows)]


def _surface(found: SurfaceErrors) -> list[str]:
    rows = [
        [row.name, *(number(value, 1) for value in (row.told_deg, row.right_deg, row.overclaimed_deg))]
        for row in found.stations
    ]
    return [
        f"Surface: {found.cells} cells, {found.coverage_percent:.1f} % covered, "
        f"bias {number(found.bias_mm, 3, sign=True)} mm, noise {number(found.noise_mm, 3)} mm, "
        f"95 % within {number(found.within_95_mm, 3)} mm, {found.wrong_percent:.2f} % wrong",
        *aligned(["station", "told deg", "right deg", "overclaimed deg"], rows),
    ]


def _axis(found: AxisErrors) -> str:
    return (
        f"Axis over {found.length_m:.3f} m: bow {number(found.bow_mm, 3)} mm, in truth "
        f"{number(found.true_bow_mm, 3)} mm, diff {number(found.bow_difference_mm, 3, sign=True)} mm, "
        f"course within {number(found.rms_mm, 3)} mm (rms)"
    )


def _relief(found: ReliefErrors) -> list[str]:
    rows = [
        [
            row.kind,
            number(row.position_m, 3),
            number(row.azimuth_deg, 1),
            number(row.found_mm, 3),
            number(row.truth_mm, 3),
            number(row.difference_mm, 3, sign=True),
            number(row.sigma_mm, 3),
            number(row.away_mm, 1),
        ]
        for row in found.entries
    ]
    head = ["relief", "at m", "azimuth deg", "found mm", "truth mm", "diff mm", "sigma mm", "away mm"]
    count = f"missed {found.missed}, false {found.false}, ribs {found.ridges_found} of {found.ridges_true}"
    return [*aligned(head, rows), count]
