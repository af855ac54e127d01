"""An evaluation as text for the screen: the paper's Table 2, then cameras, lenses and surface."""

import math
from collections.abc import Iterator, Sequence

from pipeline.evaluate.records import CameraComparison, Evaluation, LensErrors, SurfaceErrors

PAPER_MAE_MM = 1.0053
"""Mean absolute error of the paper's Table 2."""


def format_table(evaluation: Evaluation) -> str:
    """Lay out the evaluation in aligned columns; a number that is not known is a dash."""
    parts = [_diameters(evaluation)]
    if evaluation.cameras is not None:
        parts.append(_cameras(evaluation.cameras))
    if evaluation.lenses is not None:
        parts.append(_lenses(evaluation.lenses))
    if evaluation.surface is not None:
        parts.append(_surface(evaluation.surface))
    parts.append([f"Axis: straight within {_number(evaluation.straightness_mm_per_m, 3)} mm per metre"])
    return "\n\n".join("\n".join(lines) for lines in parts) + "\n"


def _diameters(evaluation: Evaluation) -> list[str]:
    found = evaluation.diameters
    rows = [
        [
            row.name,
            _number(row.position_m, 3),
            _number(row.model_mm, 3),
            _number(row.truth_mm, 3),
            _number(row.difference_mm, 3, sign=True),
            _number(row.relative_percent, 3),
            _number(row.sigma_mm, 3),
            _number(row.z, 1),
        ]
        for row in found.stations
    ]
    head = ["station", "at m", "model mm", "truth mm", "diff mm", "error %", "sigma mm", "z"]
    return [
        f"Diameters of {evaluation.name}",
        *_aligned(head, rows),
        f"MAE {found.mean_absolute_mm:.4f} mm, largest {found.largest_mm:.3f} mm "
        f"(the paper's MAE: {PAPER_MAE_MM} mm)",
    ]


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
                *(_number(v, 3) for v in (row.radial_mm, row.around_mm, row.along_mm, row.position_mm)),
                _number(row.attitude_deg, 4),
            ]
            for row in rows
        ]
        lines += [title, *_aligned(head, table)]
    return lines


def _lenses(found: Sequence[LensErrors]) -> list[str]:
    rows = [
        [
            row.block,
            _number(row.focal_percent, 3, sign=True),
            _number(row.lambda_error, 5, sign=True),
            _number(row.displacement_px, 3),
        ]
        for row in found
    ]
    return ["Lenses against truth", *_aligned(["block", "focal %", "lambda", "largest px"], rows)]


def _surface(found: SurfaceErrors) -> list[str]:
    return [
        f"Surface: {found.cells} cells, {found.coverage_percent:.1f} % covered, "
        f"bias {_number(found.bias_mm, 3, sign=True)} mm, noise {_number(found.noise_mm, 3)} mm, "
        f"95 % within {_number(found.within_95_mm, 3)} mm, axis bow {_number(found.bow_mm, 3)} mm"
    ]


def _number(value: float, digits: int, *, sign: bool = False) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:+.{digits}f}" if sign else f"{value:.{digits}f}"


def _aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(len(cell) for cell in column) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows):
        cells = [row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]
        yield "  ".join(cells).rstrip()
