"""What is left of a survey that was cut otherwise before: none of it may be opened as if it belonged.

Takes the run folder and the segments of today; removes what neither resumes nor tells anything any more.
"""

import shutil
from pathlib import Path

from pipeline.core.files import unwritable
from pipeline.segments.plan import SEGMENTS, Segment

KEPT = ("all-frames.", "timing.")
"""Products of the whole survey, however it is cut."""


def drop_leftovers(run_folder: Path, segments: tuple[Segment, ...]) -> None:
    """Remove segments that are none any more, and of a run in segments the products of the run in one piece.

    Args:
        run_folder: of the whole survey.
        segments: of today; a single one is a run in one piece.

    Raises:
        StageError: they cannot be removed.
    """
    cut = len(segments) > 1
    names = {s.name for s in segments} if cut else set()
    old = [p for p in (run_folder / SEGMENTS).glob("*") if p.name not in names]
    files = [p for p in (run_folder / "products").glob("*") if cut and not p.name.startswith(KEPT)]
    for path in (*old, *files):
        try:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        except OSError as error:
            raise unwritable(path, error, "run") from error
