"""What a finished steel run tells on the screen, in a few lines."""

import math

from pipeline.report.steel.directions import wind
from pipeline.report.steel.gross import GrossGroup, grouped
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.residuals import point_residual_mm
from pipeline.report.steel.structure_rows import ColumnRow
from pipeline.steel.registration_records import GrossKind

_ROWS = 25


def summary(report: SteelReport) -> str:
    """Registration, gross errors, columns, nodes, deflection, warnings."""
    worst = max(report.stations, key=lambda row: row.sigma_mm)
    counted = {kind: sum(row.kind == kind for row in report.targets) for kind in ("point", "line", "plane")}
    figures = f", {counted['line']} axes and {counted['plane']} planes"
    if not counted["line"] + counted["plane"]:
        figures = ""
    lines = [
        f"{report.name}: {len(report.stations)} stations and {counted['point']} targets{figures} adjusted "
        f"together, residual {_mm(point_residual_mm(report), 2)} (3D, rms), largest sigma "
        f"{_mm(worst.sigma_mm, 2)} ({worst.name})",
        *_gross(report),
        *_columns(report),
        *_nodes(report),
        *_deflection(report),
        *(f"note: {warning}" for warning in report.warnings),
    ]
    return "\n".join(lines)


def _gross(report: SteelReport) -> list[str]:
    if not report.gross:
        return ["no gross errors"]
    return [f"gross error: {_gross_words(group)}" for group in grouped(report.gross)]


def _gross_words(group: GrossGroup) -> str:
    error = group.first
    if error.kind is GrossKind.MISNAMED:
        fits = f", it is {error.fits}" if error.fits else ""
        return f"what {error.station} calls {error.target} stands {_mm(error.size_mm, 1)} off it{fits}"
    sizes = " to ".join(f"{size:.1f}" for size in _ends([row.size_mm for row in group.errors])) + " mm"
    unsure = f" (or from {error.instead}: no third station tells)" if error.instead else ""
    return f"{error.target} was moved: {', '.join(group.together)} see it {sizes} off{unsure}"


def _ends(sizes: list[float]) -> list[float]:
    """Smallest and largest, or the one there is."""
    return [min(sizes), max(sizes)] if len(sizes) > 1 else sizes


def _columns(report: SteelReport) -> list[str]:
    if not report.columns:
        return []
    over = sum(row.over_limit for row in report.columns)
    lines = [f"{over} of {len(report.columns)} columns lean more than they may:"]
    width = max(len(row.name) for row in report.columns)
    lines += [_column(row, width) for row in report.columns[:_ROWS]]
    left = len(report.columns) - _ROWS
    return [*lines, f"  and {left} more in columns.csv"] if left > 0 else lines


def _column(row: ColumnRow, width: int) -> str:
    lean = f"{row.deviation_mm:7.2f} +- {row.sigma_mm:.2f} mm  {wind(row.direction_deg):<10}"
    verdict = ("  over" if row.over_limit else "") + ("" if row.certain else "  near the limit")
    return f"  {row.name:<{width}}  {lean}  1/{row.ratio:.0f}{verdict}"


def _nodes(report: SteelReport) -> list[str]:
    judged = [row for row in report.nodes if math.isfinite(row.size_mm)]
    if not judged:
        return []
    loud = sorted((row for row in judged if row.significant), key=lambda row: -row.size_mm)
    most = f", the most {loud[0].name} by {_mm(loud[0].size_mm, 1)}" if loud else ""
    return [f"{len(loud)} of {len(judged)} nodes are eccentric{most}"]


def _deflection(report: SteelReport) -> list[str]:
    found = report.deflection
    if found is None:
        return []
    verdict = "over" if found.over_limit else "within"
    return [
        f"largest deflection {_mm(found.largest_mm, 1)} at {found.largest_node}, {verdict} the limit of "
        f"{_mm(found.limit_mm, 1)}"
    ]


def _mm(value: float, digits: int) -> str:
    return f"{value:.{digits}f} mm" if math.isfinite(value) else "unknown"
