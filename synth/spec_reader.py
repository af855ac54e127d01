"""Strict reading of SPEC.toml: bytes in, :class:`~synth.spec.Spec` out, everything odd refused.

Unknown keys, wrong types and impossible values raise StageError naming the key in full.  Knows the shape of
the specification only through its dataclasses.
"""

import dataclasses
import math
import tomllib
import types
import typing
from enum import StrEnum
from pathlib import Path
from typing import Any

from pipeline.core.errors import StageError
from synth.spec import Spec
from synth.spec_check import STAGE, check_together, refuse

POSITIVE = frozenset(
    [
        "texel_mm",
        "height_mm",
        "width_mm",
        "length_mm",
        "pitch_m",
        "margin_m",
        "standoff_m",
        "travel_m",
        "focal_px",
        "width_px",
        "height_px",
        "samples",
        "frames_per_second",
        "lamp_strength",
        "exposure",
        "cameras",
        "diameter_mm",
    ]
)
NON_NEGATIVE = frozenset(
    [
        "seed",
        "ovality_mm",
        "sway_deg",
        "sway_mm",
        "speed_wander_mm",
        "mounting_deg",
        "mounting_mm",
        "daylight",
        "sky",
        "full_well_e",
        "read_noise_e",
        "motion_blur_mm",
        "bow_mm",
        "speck_density",
        "video_mbit_per_s",
        "focal_spread_percent",
        "travel_sigma_mm",
    ]
)
FRACTION = frozenset(
    ["grain", "dirt", "streaks", "scratches", "speckle", "mottling", "gloss", "vignetting", "readout_share"]
)


def read_spec(path: Path) -> Spec:
    """Read and check a specification.

    Args:
        path: a TOML file.

    Raises:
        StageError: the file is missing, no TOML, or says something unknown or impossible.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StageError(STAGE, f"{path} cannot be read ({error})", "name an existing SPEC.toml") from error
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise StageError(STAGE, f"{path} is not TOML ({error})", "correct that line") from error
    return parse_spec(table)


def parse_spec(table: dict[str, Any]) -> Spec:
    """Build a specification from a TOML table; raises StageError as :func:`read_spec` does."""
    spec: Spec = _record(Spec, table, "")
    check_together(spec)
    return spec


def effective(spec: Spec) -> dict[str, Any]:
    """Return the specification with all defaults filled in, as plain JSON values."""
    return dataclasses.asdict(spec)


def _record(kind: type, table: object, prefix: str) -> Any:  # noqa: ANN401 - the kind asked for
    if not isinstance(table, dict):
        refuse(prefix.rstrip("."), f"must be a table, not {table!r}", "write it as [section]")
    hints = typing.get_type_hints(kind)
    for key in table:
        if key not in hints:
            refuse(f"{prefix}{key}", "is unknown", f"use one of: {', '.join(sorted(hints))}")
    values = {key: _value(hints[key], value, f"{prefix}{key}") for key, value in table.items()}
    required = [
        f.name
        for f in dataclasses.fields(kind)
        if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    for name in required:
        if name not in values:
            refuse(f"{prefix}{name}", "is missing", "give it a value")
    return kind(**values)


def _value(hint: Any, value: object, key: str) -> Any:  # noqa: ANN401 - the hint decides
    if isinstance(hint, types.UnionType):
        hint = next(arg for arg in typing.get_args(hint) if arg is not type(None))
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return _record(hint, value, f"{key}.")
    if typing.get_origin(hint) is tuple:
        return _tuple(typing.get_args(hint), value, key)
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        if value not in list(hint):
            refuse(key, f"is {value!r}", f"use one of: {', '.join(hint)}")
        return hint(str(value))
    return _scalar(hint, value, key)


def _tuple(args: tuple[Any, ...], value: object, key: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        refuse(key, f"must be a list, not {value!r}", "write it in square brackets")
    if args[-1] is Ellipsis:
        return tuple(_value(args[0], item, f"{key}[{i}]") for i, item in enumerate(value))
    if len(value) != len(args):
        refuse(key, f"has {len(value)} values", f"give {len(args)}")
    return tuple(
        _value(arg, item, f"{key}[{i}]") for i, (arg, item) in enumerate(zip(args, value, strict=True))
    )


def _scalar(hint: type, value: object, key: str) -> Any:  # noqa: ANN401 - float, int, bool or str
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        refuse(key, f"is {value!r}", f"give a value of type {hint.__name__}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        _check_number(value, key)
    if value == "":
        refuse(key, "is empty", "give it a text")
    return value


def _check_number(value: float, key: str) -> None:
    name = key.rsplit(".", 1)[-1]
    if not math.isfinite(value):
        refuse(key, f"is {value}", "give a finite number")
    if name in POSITIVE and value <= 0:
        refuse(key, f"is {value}", "give a number above 0")
    if name in NON_NEGATIVE and value < 0:
        refuse(key, f"is {value}", "give 0 or more")
    if name in FRACTION and not 0 <= value <= 1:
        refuse(key, f"is {value}", "give a number from 0 to 1")
    if name == "frames" and value < 2:
        refuse(key, f"is {value}", "give at least 2 frames")
    if name == "drawn_out" and value < 1:
        refuse(key, f"is {value}", "give 1 or more")
    if name == "video_crf" and not 0 <= value <= 51:
        refuse(key, f"is {value}", "give a number from 0 to 51")
