"""Writing a result under a temporary name and renaming it, so that nobody ever reads half a file."""

import os
from pathlib import Path

from pipeline.core.errors import StageError


def write_whole(path: Path, payload: bytes) -> Path:
    """Write ``payload`` to ``path``, all of it or nothing, and give the path back.

    Raises:
        StageError: the folder is missing, not writable or full.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(payload)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise StageError(
            "report", f"{path} cannot be written ({error.strerror})", "choose a folder that can be written"
        ) from error
    return path
