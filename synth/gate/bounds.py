"""The bounds of the gate, read strictly from specs/gate/bounds.toml.

Takes the file; gives :class:`Bounds` for every scenario and figure.  Every figure needs both of its sides in
every scenario, so that nobody opens the gate by leaving a line out.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeline.core.errors import StageError
from synth.gate.figures import FIGURES

BOUNDS_FILE = Path(__file__).parents[2] / "specs" / "gate" / "bounds.toml"


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """A figure may lie anywhere from ``least`` to ``most``, both included."""

    least: float
    most: float

    def hold(self, value: float | None) -> bool:
        """Is the figure there and between the bounds?"""
        return value is not None and self.least <= value <= self.most


def read_bounds(path: Path = BOUNDS_FILE) -> dict[str, dict[str, Bounds]]:
    """Read scenario -> figure -> bounds.

    Raises:
        StageError: the file is missing or no TOML; a figure is unknown or has no bounds; bounds are not two
            finite numbers in ascending order.
    """
    try:
        scenarios = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StageError("gate", f"{path} cannot be read", "give the file with the bounds") from error
    except tomllib.TOMLDecodeError as error:
        raise StageError("gate", f"{path} is no TOML ({error})", "correct that line") from error
    if not scenarios:
        raise StageError("gate", f"{path} names no scenario", "add a table of bounds")
    return {name: _scenario(f"{path}: {name}", found) for name, found in scenarios.items()}


def _scenario(where: str, found: object) -> dict[str, Bounds]:
    if not isinstance(found, Mapping):
        raise StageError("gate", f"{where} is no table", "write it as [scenario] with a line for each figure")
    for name in found:
        if name not in FIGURES:
            raise StageError("gate", f"{where}.{name} is no figure", f"known are {', '.join(FIGURES)}")
    for name in FIGURES:
        if name not in found:
            raise StageError("gate", f"{where}.{name} is missing", f"add {name} = [least, most]")
    return {name: _bounds(f"{where}.{name}", found[name]) for name in FIGURES}


def _bounds(where: str, found: object) -> Bounds:
    numbers = [float(n) for n in found if _is_number(n)] if isinstance(found, list) else []
    if not isinstance(found, list) or len(numbers) != len(found) or len(numbers) != 2:
        raise StageError("gate", f"{where} is not two finite numbers", "write it as [least, most]")
    if numbers[0] > numbers[1]:
        raise StageError("gate", f"{where} starts above its end", "write it as [least, most]")
    return Bounds(least=numbers[0], most=numbers[1])


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
