"""Products on disk: frozen dataclasses to one .npz file and back, and the stamp that identifies them.

Knows numbers, strings, paths, enums, arrays, tuples, optional values, string-keyed dictionaries and nested
frozen dataclasses; anything else is a programming error and raises TypeError.  Paths inside the run folder
are stored relative to it, so that a run folder can be moved.
"""

import dataclasses
import hashlib
import json
import types
import typing
from enum import Enum
from pathlib import Path
from typing import Any, cast

import numpy as np

from pipeline.core.files import replacing

_META = "product"
_ARRAY, _INSIDE = "$array", "$inside"


def save(value: object, path: Path, root: Path) -> None:
    """Write a frozen dataclass to ``path`` (.npz), whole or not at all; ``root`` is the run folder."""
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    tree = _encode(value, arrays, root)
    text = np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8)
    with replacing(path, "run") as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **{_META: text}, **arrays)


def load[T](kind: type[T], path: Path, root: Path) -> T:
    """Read a frozen dataclass of type ``kind`` that :func:`save` wrote.

    Raises:
        FileNotFoundError: the product or a file that it names is gone.
    """
    with np.load(path, allow_pickle=False) as archive:
        tree = json.loads(archive[_META].tobytes().decode())
        return cast(T, _decode(kind, tree, archive, root))


def stamp(*values: object, root: Path | None = None) -> str:
    """A digest of everything a result depends on: equal inputs and options give an equal stamp.

    Files inside ``root``, the run folder, count by their place in it: it may be moved.
    """
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    tree = _encode(list(values), arrays, root)
    digest = hashlib.blake2b(json.dumps(tree, sort_keys=True).encode(), digest_size=16)
    for key, array in arrays.items():
        digest.update(f"{key}{array.dtype}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def layout(kind: Any) -> object:  # noqa: ANN401 - types are data here
    """Names of a product's fields, nested: a product written with another layout must be made again."""
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return {name: layout(hint) for name, hint in typing.get_type_hints(kind).items()}
    return [found for a in typing.get_args(kind) if (found := layout(a))]


def stamp_file(path: Path) -> str:
    """A digest of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _encode(value: object, arrays: dict[str, np.ndarray[Any, Any]], root: Path | None) -> object:
    if isinstance(value, np.ndarray):
        key = f"a{len(arrays)}"
        arrays[key] = value
        return {_ARRAY: key}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        if root is not None and value.is_relative_to(root):
            return {_INSIDE: value.relative_to(root).as_posix()}
        return value.as_posix()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: _encode(getattr(value, f.name), arrays, root) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: _encode(item, arrays, root) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_encode(item, arrays, root) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a product cannot hold {type(value).__name__}")


def _decode(kind: Any, tree: Any, archive: Any, root: Path) -> Any:  # noqa: ANN401 - types are data here
    if isinstance(tree, dict) and _ARRAY in tree:
        return archive[tree[_ARRAY]]
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        chosen = next(a for a in arguments if a is not type(None))
        return None if tree is None else _decode(chosen, tree, archive, root)
    if origin is tuple:
        kinds = [arguments[0]] * len(tree) if arguments[-1] is ... else arguments
        return tuple(_decode(k, item, archive, root) for k, item in zip(kinds, tree, strict=True))
    if origin is dict:
        return {key: _decode(arguments[1], item, archive, root) for key, item in tree.items()}
    if kind is Path:
        return _present(root / tree[_INSIDE] if isinstance(tree, dict) else Path(tree))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(tree)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        return kind(**{name: _decode(hints[name], item, archive, root) for name, item in tree.items()})
    return tree


def _present(path: Path) -> Path:
    if not path.exists():
        raise FileNotFoundError(path)
    return path
