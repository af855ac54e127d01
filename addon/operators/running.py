"""What a run is told: its folder and the words of its command line; and its start."""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError

from ..gather import gather_survey, survey_path
from ..hand_pairs import pairs_words
from ..jobs import Job, pipeline_command
from ..library import python_executable
from ..preferences import preferences
from ..properties.run import CableTwinRun
from .survey import save_survey


def start_reconstruction(context: bpy.types.Context, *more: str) -> tuple[Job, tuple[str, ...]]:
    """Save the scene's survey and start the pipeline on it.

    Returns:
        What :meth:`.following.JobOperator.start` does.

    Raises:
        StageError: the survey is refused, no run folder is chosen, or it cannot be started.
    """
    scene = context.scene
    survey, run = gather_survey(scene), scene.cabletwin.run
    folder, path = run_folder(run), survey_path(scene.cabletwin.survey)
    save_survey(scene, path)
    words = [*run_words(run, path, folder), *pairs_words(scene, folder)]
    words += ["--language", preferences(context).report_language, *more]
    job = Job(pipeline_command(python_executable(), *words), folder / "log.jsonl")
    return job, tuple(b.name for b in survey.blocks)


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
