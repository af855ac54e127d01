"""Options are data: frozen dataclasses built strictly from a mapping (a TOML table, a command-line word).

Takes a dataclass and a mapping; gives an instance, or one sentence that names the key.  Leaves out reading
files and rules that tie several keys together (the survey checks those).

A field may carry metadata: ``key`` (its name in the file), ``minimum``, ``maximum``, ``above`` (numbers;
arrays are checked element by element).
"""

import difflib
import math
import tomllib
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

from pipeline.core.errors import StageError

_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a text in quotes",
    Path: "a path in quotes",
}


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Where in the file we are: the full dotted key, and who speaks when something is wrong there."""

    key: str
    stage: str

    def into(self, name: str) -> "_Place":
        return replace(self, key=f"{self.key}.{name}" if self.key else name)

    def item(self, number: int, value: object) -> "_Place":
        """Into an array of tables: by the table's name where it has one, else by its number from 1."""
        name = value.get("name") if isinstance(value, Mapping) else None
        label = name if isinstance(name, str) and name else str(number)
        return replace(self, key=f"{self.key}[{label}]")

    def error(self, cause: str, remedy: str) -> StageError:
        return StageError(self.stage, cause, remedy)


def build[T](kind: type[T], values: object, *, key: str = "", stage: str = "survey") -> T:
    """Build a dataclass from a mapping, refusing all that does not fit.

    Args:
        kind: the dataclass; nested dataclasses, tuples, enums (by value), paths and ``X | None`` are
            understood.
        values: what the file holds at this place.
        key: full dotted name of this place, for messages; "" at the top of the file.
        stage: who speaks in the error.

    Raises:
        StageError: unknown or missing key, wrong type, value outside its range.
    """
    place = _Place(key=key, stage=stage)
    return typing.cast("T", _table(kind, values, place))


def override[T](options: T, assignment: str, *, key: str = "", stage: str = "options") -> T:
    """Replace one option by a command-line word ``key=value`` (``a.b=value`` for nested ones).

    The value is read as TOML; a bare word that is no TOML is taken as a text.

    Raises:
        StageError: no equals sign, unknown key, or a value that does not fit.
    """
    name, equals, text = assignment.partition("=")
    place = _Place(key=key, stage=stage)
    if not equals or not name.strip():
        raise place.error(f'"{assignment}" is no assignment', "write it as key=value")
    return typing.cast("T", _replaced(options, name.strip().split("."), _toml_value(text.strip()), place))


def _replaced(options: object, names: Sequence[str], value: object, place: _Place) -> object:
    known = {_key_of(field): field for field in fields(typing.cast("Any", options))}
    field = known.get(names[0])
    if field is None:
        raise _unknown(names[0], known, place)
    inside = place.into(names[0])
    if len(names) > 1:
        current = getattr(options, field.name)
        if not is_dataclass(current):
            raise inside.error(f"{inside.key} has no keys of its own", "leave out what follows it")
        new = _replaced(current, names[1:], value, inside)
    else:
        new = _value(typing.get_type_hints(type(options))[field.name], value, inside)
        _check_range(field, new, inside)
    return replace(typing.cast("Any", options), **{field.name: new})


def _toml_value(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _key_of(field: Field[Any]) -> str:
    return str(field.metadata.get("key", field.name))


def _unknown(name: str, known: Mapping[str, object], place: _Place) -> StageError:
    full = place.into(name).key
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    remedy = (
        f"perhaps {place.into(near[0]).key} is meant"
        if near
        else f"known here are {', '.join(sorted(known))}"
    )
    return place.error(f"unknown key {full}", remedy)


def _table(kind: Any, values: object, place: _Place) -> object:  # noqa: ANN401 - any dataclass
    if not isinstance(values, Mapping):
        raise place.error(
            f"{place.key or 'the file'} is {_say(values)}", f"write it as [{place.key}], a table"
        )
    known = {_key_of(field): field for field in fields(kind) if field.init}
    for name in values:
        if name not in known:
            raise _unknown(str(name), known, place)
    hints = typing.get_type_hints(kind)
    found: dict[str, object] = {}
    for name, field in known.items():
        inside = place.into(name)
        if name in values:
            found[field.name] = _value(hints[field.name], values[name], inside)
            _check_range(field, found[field.name], inside)
        elif field.default is MISSING and field.default_factory is MISSING:
            raise place.error(f"{inside.key} is missing", "add it")
    return kind(**found)


def _value(hint: Any, value: object, place: _Place) -> object:  # noqa: ANN401 - any annotation
    origin = typing.get_origin(hint)
    if origin in (typing.Union, types.UnionType):
        choices = [choice for choice in typing.get_args(hint) if choice is not type(None)]
        return None if value is None else _value(choices[0], value, place)
    if origin is tuple:
        return _tuple(typing.get_args(hint), value, place)
    if is_dataclass(hint):
        return _table(hint, value, place)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _choice(hint, value, place)
    if origin is Mapping or hint is Mapping:
        return _mapping(value, place)
    return _scalar(hint, value, place)


def _scalar(hint: type, value: object, place: _Place) -> object:
    wanted: tuple[type, ...] = {float: (int, float), Path: (str, Path)}.get(hint, (hint,))
    # bool is an int to Python, not to a person
    if not isinstance(value, wanted) or (isinstance(value, bool) and hint is not bool):
        raise place.error(f"{place.key} is {_say(value)}", f"write {_WORDS.get(hint, hint.__name__)}")
    if hint is float and not math.isfinite(typing.cast("float", value)):
        raise place.error(f"{place.key} is {value}", "write a finite number")
    return hint(value)


def _choice(hint: type[Enum], value: object, place: _Place) -> Enum:
    values = [str(member.value) for member in hint]
    if value not in values:
        raise place.error(f"{place.key} is {_say(value)}", f"choose one of {', '.join(values)}")
    return hint(value)


def _tuple(hints: tuple[Any, ...], value: object, place: _Place) -> tuple[object, ...]:
    if not isinstance(value, list | tuple):
        raise place.error(f"{place.key} is {_say(value)}", "write a list in square brackets")
    if hints[-1] is Ellipsis:
        items = enumerate(value, start=1)
        return tuple(_value(hints[0], item, place.item(number, item)) for number, item in items)
    if len(value) != len(hints):
        raise place.error(f"{place.key} has {len(value)} values", f"give {len(hints)}")
    pairs = zip(hints, value, strict=True)
    return tuple(_value(hint, v, place.item(n, v)) for n, (hint, v) in enumerate(pairs, start=1))


def _mapping(value: object, place: _Place) -> Mapping[str, object]:
    if not isinstance(value, Mapping):
        raise place.error(f"{place.key} is {_say(value)}", f"write it as [{place.key}], a table")
    return dict(value)


def _check_range(field: Field[Any], value: object, place: _Place) -> None:
    rules = field.metadata
    if value == () and ("above" in rules or "minimum" in rules):
        raise place.error(f"{place.key} is empty", "give at least one number")
    for number in value if isinstance(value, tuple) else (value,):
        if not isinstance(number, int | float):
            continue
        if "above" in rules and not number > rules["above"]:
            raise place.error(f"{place.key} is {number:g}", f"it must be above {rules['above']:g}")
        if "minimum" in rules and not number >= rules["minimum"]:
            raise place.error(f"{place.key} is {number:g}", f"it must be at least {rules['minimum']:g}")
        if "maximum" in rules and not number <= rules["maximum"]:
            raise place.error(f"{place.key} is {number:g}", f"it must be at most {rules['maximum']:g}")


def _say(value: object) -> str:
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()
