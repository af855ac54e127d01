"""What a run is told: its folder and the words of its command line."""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError

from ..properties.run import CableTwinRun


def run_folder(run: CableTwinRun) -> Path:
    """The absolute run folder.

    Raises:
        StageError: none is chosen.
    """
    if not run.folder:
        raise StageError("run", "no run folder is chosen", "choose one in the panel Reconstruct")
    return Path(bpy.path.abspath(run.folder))


def run_words(run: CableTwinRun, survey: Path, folder: Path) -> list[str]:
    """The arguments of ``python -m pipeline`` that this scene asks for."""
    words = ["run", str(survey), "--out", str(folder), "--events", "json"]
    if run.adjust == "blocks":
        words += ["--adjust", "blocks"]
    if run.truth:
        words += ["--truth", bpy.path.abspath(run.truth)]
    return words
