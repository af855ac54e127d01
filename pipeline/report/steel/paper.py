"""The figures of the paper, as printed (guo-ming-2021, section 3 and Table 1), to stand beside ours."""

from dataclasses import dataclass
from typing import Literal

STATIONS = 134
REGISTRATION_MM = 5
COLUMNS, COLUMNS_OVER = 21, 16
LEAST_MM, MOST_MM = 32.1, 68.2
LIMIT_MM = 35


@dataclass(frozen=True, kw_only=True)
class PaperLean:
    """A line of Table 1: how far a column leans one way between two measured points."""

    column: str
    direction: Literal["north", "east", "west"]
    deviation_mm: float
    height_mm: int
    ratio: int


TABLE_1 = (
    PaperLean(column="8-N", direction="north", deviation_mm=32.1, height_mm=13_914, ratio=433),
    PaperLean(column="8-N", direction="east", deviation_mm=17.3, height_mm=13_659, ratio=790),
    PaperLean(column="7-P", direction="west", deviation_mm=11.9, height_mm=14_052, ratio=1181),
    PaperLean(column="7-P", direction="north", deviation_mm=37.3, height_mm=14_069, ratio=377),
)
