"""report.json of a steel survey: every figure of the page for programs.

Takes a :class:`SteelReport`; gives a plain tree, which ``pipeline.core.files.write_json`` writes (NaN as
null).  The keys are described in docs/outputs.md; they are only ever added to.
"""

from typing import Any

from pipeline.report.steel.directions import wind
from pipeline.report.steel.records import ComparisonRow, FusionSummary, SteelReport
from pipeline.report.steel.structure_rows import ColumnRow

FORMAT = 1


def report_tree(report: SteelReport) -> dict[str, Any]:
    """The whole report as dictionaries, lists, numbers and texts."""
    return {
        "format": FORMAT,
        "kind": "steel",
        "name": report.name,
        "frame": {"base": report.base or None, "north_deg": report.north_deg},
        "stations": [vars(row) for row in report.stations],
        "targets": [vars(row) for row in report.targets],
        "gross": [vars(row) for row in report.gross],
        "rounds": report.rounds,
        "variance_components": [vars(row) for row in report.components],
        "comparison": [_comparison(row) for row in report.comparison],
        "icp_pairs": [
            {key: value for key, value in vars(row).items() if key not in ("rotation", "translation")}
            for row in report.icp_pairs
        ],
        "nodes": [vars(row) for row in report.nodes],
        "members": {
            "rods": [vars(row) for row in report.rods],
            "balls": [vars(row) for row in report.balls],
            "columns": [vars(row) for row in report.uprights],
        },
        "columns": [_column(row) for row in report.columns],
        "deflection": _deflection(report),
        "fusion": _fusion(report.fusion),
        "timing_s": dict(report.timing_s),
        "peak_memory_mb": report.peak_memory_mb,
        "warnings": list(report.warnings),
    }


def _comparison(row: ComparisonRow) -> dict[str, Any]:
    return {
        "station": row.station,
        "position": row.position,
        "chained": {
            "position_m": row.chained_m,
            "offset_mm": row.chained_offset_mm,
            "turn_arcsec": row.chained_turn_arcsec,
            "sigma_mm": row.chained_sigma_mm,
        },
        "icp": None
        if row.icp_m is None
        else {
            "position_m": row.icp_m,
            "offset_mm": row.icp_offset_mm,
            "turn_arcsec": row.icp_turn_arcsec,
        },
        "adjusted_sigma_mm": row.adjusted_sigma_mm,
    }


def _column(row: ColumnRow) -> dict[str, Any]:
    return {**vars(row), "direction": wind(row.direction_deg), "ratio": row.ratio}


def _deflection(report: SteelReport) -> dict[str, Any] | None:
    if report.deflection is None:
        return None
    return {**vars(report.deflection), "rows": [vars(row) for row in report.deflection.rows]}


def _fusion(fusion: FusionSummary | None) -> dict[str, Any] | None:
    if fusion is None:
        return None
    pairs = [{"name": name, "residual_mm": size} for name, size in fusion.pairs]
    photos = [{"name": name, "position_m": place} for name, place in fusion.photos]
    told = {key: value for key, value in vars(fusion).items() if key != "residuals_mm"}
    return told | {"pairs": pairs, "photos": photos}
