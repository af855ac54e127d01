"""A TOML file as a mapping, or one sentence that says why it is none."""

import tomllib
from collections.abc import Mapping
from pathlib import Path

from pipeline.core.errors import StageError


def read_toml(path: Path, stage: str, wanted: str) -> Mapping[str, object]:
    """Read a TOML file.

    Args:
        path: of the file.
        stage: who speaks in the error.
        wanted: what the file should be, e.g. "a survey.toml".

    Raises:
        StageError: the file is missing, no UTF-8 or no TOML.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise StageError(stage, f"{path} cannot be read ({reason})", f"give the path of {wanted}") from error
    except UnicodeDecodeError as error:
        raise StageError(stage, f"{path} is no UTF-8 text", f"give the path of {wanted}") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise StageError(stage, f"{path} is no TOML: {error}", "correct that line") from error
