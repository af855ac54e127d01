"""The colours that mean something: the same in plots, models and the 3D view."""

import colorsys

from pipeline.report.steel.structure_rows import ColumnRow, NodeRow

STEEL = "#9aa7b2"
GOOD = "#009e73"
UNSURE = "#e69f00"
BAD = "#d55e00"
UNKNOWN = "#56b4e9"
STATION = "#0072b2"


def of_column(row: ColumnRow) -> str:
    """Green within its limit, vermillion over it, orange where two sigma do not tell."""
    if not row.certain:
        return UNSURE
    return BAD if row.over_limit else GOOD


def of_node(row: NodeRow) -> str:
    """Vermillion where ball and rods are apart for certain."""
    return BAD if row.significant else GOOD


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green, blue, 0 to 255, of "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def of_station(number: int) -> tuple[int, int, int]:
    """Red, green, blue of a station's points: hues by the golden angle, so that neighbours differ."""
    red, green, blue = colorsys.hls_to_rgb((0.58 + 0.381966 * number) % 1, 0.55, 0.62)
    return round(255 * red), round(255 * green), round(255 * blue)
