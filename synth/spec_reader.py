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
from synth.lens import max_distorted_radius
from synth.spec import Spec
from synth.surface import largest_radius_m

STAGE = "spec"

POSITIVE = frozenset(
    "texel_mm height_mm width_mm pitch_m margin_m standoff_m travel_m focal_px width_px height_px samples "
    "frames_per_second lamp_strength exposure cameras diameter_mm".split()
)
NON_NEGATIVE = frozenset(
    "seed ovality_mm sway_deg sway_mm speed_wander_mm mounting_deg mounting_mm daylight full_well_e "
    "read_noise_e motion_blur_mm focal_spread_percent".split()
)
FRACTION = frozenset("grain dirt streaks scratches speckle vignetting".split())


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
    _check_together(spec)
    return spec


def effective(spec: Spec) -> dict[str, Any]:
    """Return the specification with all defaults filled in, as plain JSON values."""
    return dataclasses.asdict(spec)


def _refuse(key: str, problem: str, remedy: str) -> typing.NoReturn:
    raise StageError(STAGE, f"{key} {problem}", remedy)


def _record(kind: type, table: object, prefix: str) -> Any:  # noqa: ANN401 - the kind asked for
    if not isinstance(table, dict):
        _refuse(prefix.rstrip("."), f"must be a table, not {table!r}", "write it as [section]")
    hints = typing.get_type_hints(kind)
    for key in table:
        if key not in hints:
            _refuse(f"{prefix}{key}", "is unknown", f"use one of: {', '.join(sorted(hints))}")
    values = {key: _value(hints[key], value, f"{prefix}{key}") for key, value in table.items()}
    required = [
        f.name
        for f in dataclasses.fields(kind)
        if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    for name in required:
        if name not in values:
            _refuse(f"{prefix}{name}", "is missing", "give it a value")
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
            _refuse(key, f"is {value!r}", f"use one of: {', '.join(hint)}")
        return hint(value)
    return _scalar(hint, value, key)


def _tuple(args: tuple[Any, ...], value: object, key: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        _refuse(key, f"must be a list, not {value!r}", "write it in square brackets")
    if args[-1] is Ellipsis:
        return tuple(_value(args[0], item, f"{key}[{i}]") for i, item in enumerate(value))
    if len(value) != len(args):
        _refuse(key, f"has {len(value)} values", f"give {len(args)}")
    return tuple(_value(arg, item, f"{key}[{i}]") for i, (arg, item) in enumerate(zip(args, value, strict=True)))


def _scalar(hint: type, value: object, key: str) -> Any:  # noqa: ANN401 - float, int, bool or str
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        _refuse(key, f"is {value!r}", f"give a value of type {hint.__name__}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        _check_number(value, key)
    if value == "":
        _refuse(key, "is empty", "give it a text")
    return value


def _check_number(value: float, key: str) -> None:
    name = key.rsplit(".", 1)[-1]
    if not math.isfinite(value):
        _refuse(key, f"is {value}", "give a finite number")
    if name in POSITIVE and value <= 0:
        _refuse(key, f"is {value}", "give a number above 0")
    if name in NON_NEGATIVE and value < 0:
        _refuse(key, f"is {value}", "give 0 or more")
    if name in FRACTION and not 0 <= value <= 1:
        _refuse(key, f"is {value}", "give a number from 0 to 1")
    if name == "frames" and value < 2:
        _refuse(key, f"is {value}", "give at least 2 frames")
    if name == "video_crf" and not 0 <= value <= 51:
        _refuse(key, f"is {value}", "give a number from 0 to 51")


def _check_together(spec: Spec) -> None:
    """Refuse what only a look at several keys can refuse."""
    _check_stations(spec)
    _check_fillet(spec)
    reach_m = largest_radius_m(spec.cable) + 0.02
    if spec.robot.standoff_m < reach_m:
        _refuse("robot.standoff_m", f"is {spec.robot.standoff_m} m", f"give at least {reach_m:.3f} m")
    if len({angle % 360.0 for angle in spec.angles_deg}) < len(spec.angles_deg):
        _refuse("robot.angles_deg", "names the same place twice", "give every camera its own azimuth")
    for i, frame in enumerate(spec.depth_frames):
        if not 0 <= frame < spec.robot.frames:
            _refuse(f"depth_frames[{i}]", f"is {frame}", f"give a frame from 0 to {spec.robot.frames - 1}")
    if spec.sensor.output == "video" and (spec.lens.width_px % 2 or spec.lens.height_px % 2):
        _refuse("lens.width_px, lens.height_px", "are odd", "a video needs even numbers")
    if max_distorted_radius(spec.lens) is None:
        _refuse(
            "lens.division_lambda",
            f"is {spec.lens.division_lambda}, which folds the image within the frame",
            "give a smaller one",
        )


def _check_stations(spec: Spec) -> None:
    stations = spec.cable.station
    names = [station.name for station in stations]
    if len(set(names)) < len(names):
        _refuse("cable.station", f"has a name twice among {names}", "give every station its own name")
    positions = [station.position_m for station in stations]
    if any(b <= a for a, b in zip(positions, positions[1:], strict=False)):
        _refuse("cable.station", f"is not in order: positions {positions}", "sort by position_m")
    for i, station in enumerate(stations):
        if not 0 <= station.position_m <= spec.robot.travel_m:
            _refuse(
                f"cable.station[{i}].position_m",
                f"is {station.position_m} m",
                f"give a place on the travel, 0 to {spec.robot.travel_m} m",
            )
    given = [station.diameter_mm is not None for station in stations]
    if any(given) and not all(given):
        _refuse("cable.station.diameter_mm", "is given for some stations", "give it for all or for none")


def _check_fillet(spec: Spec) -> None:
    fillet = spec.cable.fillet
    if fillet is not None and fillet.width_mm >= math.pi * spec.cable.diameter_mm / 4:
        _refuse("cable.fillet.width_mm", f"is {fillet.width_mm} mm", "keep it below a quarter of the girth")
