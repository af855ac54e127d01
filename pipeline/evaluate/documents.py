"""JSON documents read with care: each value is asked for by name, and what is missing is told by name.

Takes report.json and truth.json; gives plain values of the wanted type.  Leaves out what they mean.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError

FORMAT = 1


@dataclass(frozen=True, kw_only=True)
class Document:
    """A JSON object, or one inside another.

    Attributes:
        file: where it comes from, for messages.
        where: full key of this object, "" for the whole file.
        values: its content.
    """

    file: Path
    where: str
    values: dict[str, object]

    def __contains__(self, key: str) -> bool:
        return self.values.get(key) is not None

    def error(self, cause: str) -> StageError:
        """Say that this file does not fit."""
        return StageError("evaluate", f"{self.file}: {cause}", "give the file that this program wrote")

    def text(self, key: str) -> str:
        """A text."""
        value = self._get(key)
        if not isinstance(value, str):
            raise self.error(f"{self._full(key)} is no text")
        return value

    def number(self, key: str) -> float:
        """A finite number."""
        value = self._get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(f"{self._full(key)} is no number")
        return float(value)

    def number_or_nan(self, key: str) -> float:
        """A finite number, NaN where there is none (null)."""
        return self.number(key) if key in self else math.nan

    def array(self, key: str, *shape: int) -> NDArray[np.float64]:
        """An array of numbers; null is NaN.  In the shape, -1 stands for any length."""
        try:
            found = np.asarray(self._get(key), dtype=np.float64)
        except (TypeError, ValueError):
            raise self.error(f"{self._full(key)} is no array of numbers") from None
        if found.ndim != len(shape) or any(s not in (-1, f) for s, f in zip(shape, found.shape, strict=True)):
            wanted = " x ".join("n" if s < 0 else str(s) for s in shape)
            raise self.error(f"{self._full(key)} has the shape {found.shape}, not {wanted}")
        return found

    def inside(self, key: str) -> "Document":
        """The object under this key."""
        return self._object(self._full(key), self._get(key))

    def items(self, key: str) -> Iterator["Document"]:
        """The objects of the list under this key."""
        value = self._get(key)
        if not isinstance(value, list):
            raise self.error(f"{self._full(key)} is no list")
        return (self._object(f"{self._full(key)}[{n}]", item) for n, item in enumerate(value))

    def _get(self, key: str) -> object:
        if key not in self:
            raise self.error(f"{self._full(key)} is missing")
        return self.values[key]

    def _full(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key

    def _object(self, where: str, value: object) -> "Document":
        if not isinstance(value, dict):
            raise self.error(f"{where} is no object")
        return Document(file=self.file, where=where, values=value)


def read_document(path: Path) -> Document:
    """Read a JSON file of format 1.

    Raises:
        StageError: it is missing, no JSON, or of another format.
    """
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise StageError(
            "evaluate", f"{path} cannot be read ({reason})", "run the survey to its end and give its folder"
        ) from error
    except ValueError as error:
        raise StageError("evaluate", f"{path} is no JSON ({error})", "write the file again") from error
    document = Document(file=path, where="", values=value if isinstance(value, dict) else {})
    if document.values.get("format") != FORMAT:
        raise document.error(f"format is {document.values.get('format')}, not {FORMAT}")
    return document
