"""The tables of a steel survey as CSV: stations, nodes, columns, deflection, residuals.

Takes a :class:`SteelReport` and a folder, writes what there is, gives the names of the files.  A figure that
is not known is an empty cell; millimetres have three decimals, metres five.
"""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from pipeline.core.files import write_csv
from pipeline.report.steel.directions import wind
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.structure_rows import ColumnRow

Cell = str | int

_STATIONS = (
    *("name", "x_m", "y_m", "z_m", "sigma_mm", "sigma_x_mm", "sigma_y_mm", "sigma_z_mm", "sigma_arcsec"),
    *("ring", "parent", *(f"r{row}{column}" for row in range(3) for column in range(3))),
)
_NODES = (
    *("name", "ball_x_m", "ball_y_m", "ball_z_m", "ball_radius_mm", "rods_x_m", "rods_y_m", "rods_z_m"),
    *("eccentricity_x_mm", "eccentricity_y_mm", "eccentricity_z_mm", "eccentricity_mm", "sigma_mm"),
    *("significant", "rods"),
)
_COLUMNS = (
    *("name", "leans", "north_mm", "north_sigma_mm", "east_mm", "east_sigma_mm", "height_difference_mm"),
    *("north_ratio", "east_ratio", "deviation_mm", "sigma_mm", "direction_deg", "ratio", "limit_mm"),
    *("over_limit", "certain"),
)
_DEFLECTION = ("node", "x_m", "y_m", "z_m", "deflection_mm", "sigma_mm", "limit_mm", "support")
_RESIDUALS = (
    *("station", "target", "kind", "x_mm", "y_mm", "z_mm", "size_mm", "turn_arcsec", "normalised"),
    *("redundancy", "weight"),
)


def write_spreadsheets(folder: Path, report: SteelReport) -> tuple[str, ...]:
    """Write stations.csv, residuals.csv, and what was judged beside them.

    Raises:
        StageError: the folder cannot be written.
    """
    tables: tuple[tuple[str, Sequence[str], list[list[Cell]]], ...] = (
        ("stations.csv", _STATIONS, _stations(report)),
        ("residuals.csv", _RESIDUALS, _residuals(report)),
        ("nodes.csv", _NODES, _nodes(report)),
        ("columns.csv", _COLUMNS, [_column(row) for row in report.columns]),
        ("deflection.csv", _DEFLECTION, _deflection(report)),
    )
    present = [table for table in tables if table[2]]
    for name, head, rows in present:
        write_csv(folder / name, head, rows, "report")
    return tuple(name for name, _, _ in present)


def _stations(report: SteelReport) -> list[list[Cell]]:
    return [
        [
            row.name,
            *_metres(row.position_m),
            *_millimetres((row.sigma_mm, *row.sigma_xyz_mm)),
            _cell(row.sigma_arcsec, 2),
            row.ring,
            row.parent,
            *(f"{value:.12f}" for value in row.rotation.ravel()),
        ]
        for row in report.stations
    ]


def _nodes(report: SteelReport) -> list[list[Cell]]:
    return [
        [
            row.name,
            *_metres(row.ball_m),
            _cell(row.radius_mm, 3),
            *_metres(row.rods_m),
            *_millimetres((*row.eccentricity_mm, row.size_mm, row.sigma_mm)),
            _yes(row.significant),
            " ".join(row.rods),
        ]
        for row in report.nodes
    ]


def _column(row: ColumnRow) -> list[Cell]:
    height_mm = 1000 * row.height_m
    return [
        row.name,
        wind(row.direction_deg),
        *_millimetres((row.north_mm, row.north_sigma_mm, row.east_mm, row.east_sigma_mm)),
        _cell(height_mm, 1),
        _ratio(height_mm, row.north_mm),
        _ratio(height_mm, row.east_mm),
        *_millimetres((row.deviation_mm, row.sigma_mm)),
        _cell(row.direction_deg, 2),
        _ratio(height_mm, row.deviation_mm),
        _cell(row.limit_mm, 1),
        _yes(row.over_limit),
        _yes(row.certain),
    ]


def _deflection(report: SteelReport) -> list[list[Cell]]:
    if report.deflection is None:
        return []
    limit = _cell(report.deflection.limit_mm, 3)
    return [
        [
            row.node,
            *_metres(row.position_m),
            *_millimetres((row.deflection_mm, row.sigma_mm)),
            limit,
            _yes(row.support),
        ]
        for row in report.deflection.rows
    ]


def _residuals(report: SteelReport) -> list[list[Cell]]:
    return [
        [
            row.station,
            row.target,
            row.kind,
            *_millimetres((*row.offset_mm, math.hypot(*row.offset_mm))),
            _cell(row.turn_arcsec, 2),
            *_millimetres((row.normalised, row.redundancy, row.weight)),
        ]
        for row in report.residuals
    ]


def _ratio(height_mm: float, deviation_mm: float) -> str:
    """1/n as in Table 1; empty where a column leans less than can be told."""
    return f"1/{height_mm / abs(deviation_mm):.0f}" if abs(deviation_mm) > 1e-3 else ""


def _metres(values: Iterable[float]) -> list[str]:
    return [_cell(value, 5) for value in values]


def _millimetres(values: Iterable[float]) -> list[str]:
    return [_cell(value, 3) for value in values]


def _cell(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else ""


def _yes(value: bool) -> str:
    return "yes" if value else "no"
