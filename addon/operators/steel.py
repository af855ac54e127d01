"""Operators of a steel structure: open a run, reconstruct in a process of its own, look at what is wrong."""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError
from pipeline.progress import STEEL_SHARES

from ..jobs import Job, pipeline_command
from ..library import python_executable
from ..preferences import preferences
from ..results import steel_collections
from ..results.steel_look import choose, look_at_all
from ..results.steel_run import is_steel
from ..results.steel_show import show_steel
from ..results.view import clear_startup
from .base import FolderChoice, Operator
from .following import JobOperator


class CABLETWIN_OT_steel_choose(FolderChoice, Operator):
    """Choose the run folder of a steel structure and show it."""

    bl_idname = "cabletwin.steel_choose"
    bl_label = "Open Steel Run"
    bl_description = "Choose the run folder of a steel structure and show what it holds"
    bl_options = {"REGISTER", "UNDO"}

    def show(self, context: bpy.types.Context, folder: Path) -> None:
        """The scene remembers the folder where that went well."""
        present_steel(context, context.scene, folder)
        context.scene.cabletwin.steel.run_folder = str(folder)


class CABLETWIN_OT_steel_open(Operator):
    """Show what the run folder of the steel structure holds."""

    bl_idname = "cabletwin.steel_open"
    bl_label = "Show Steel Run"
    bl_description = "Show what the run folder of the steel structure holds now"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> None:
        """Read and show."""
        present_steel(context, context.scene, _run_folder(context.scene))


class CABLETWIN_OT_steel_run(JobOperator):
    """Reconstruct the steel structure."""

    bl_idname = "cabletwin.steel_run"
    bl_label = "Reconstruct Steel"
    bl_description = (
        "Register the stations and measure nodes, columns and deflection in the background; "
        "what is finished in the run folder is kept"
    )
    bl_options = {"REGISTER"}
    kind = "steel"
    shares = STEEL_SHARES

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Check the survey and start the pipeline on it."""
        from pipeline.steel.survey import read_steel_survey

        steel, folder = context.scene.cabletwin.steel, _run_folder(context.scene)
        if not steel.survey:
            raise StageError("survey", "no survey file is chosen", "choose one in the panel Steel structure")
        path = Path(bpy.path.abspath(steel.survey))
        survey = read_steel_survey(path)
        if (folder / "products").is_dir() and any((folder / "products").iterdir()) and not is_steel(folder):
            raise StageError(
                "run", f"{folder} holds the run of a cable", "choose another folder for the steel structure"
            )
        words = ["steel", str(path), "--out", str(folder), "--events", "json"]
        words += ["--language", preferences(context).report_language]
        if steel.truth:
            words += ["--truth", bpy.path.abspath(steel.truth)]
        job = Job(pipeline_command(python_executable(), *words), folder / "log.jsonl")
        return job, tuple(station.name for station in survey.stations)

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Show the results."""
        present_steel(context, scene, _run_folder(scene))
        self.report({"INFO"}, "Reconstructed")


class CABLETWIN_OT_steel_report(Operator):
    """Open the report of the steel structure in the browser."""

    bl_idname = "cabletwin.steel_report"
    bl_label = "Open Report"
    bl_description = "Open the report in the web browser; it needs no network"
    bl_options = {"REGISTER"}

    def work(self, context: bpy.types.Context) -> None:
        """Open the shown run's own page."""
        page = Path(bpy.path.abspath(context.scene.cabletwin.steel.folder)) / "report.html"
        if not page.is_file():
            raise StageError("run", f"{page} is gone", "run the reconstruction again")
        bpy.ops.wm.url_open(url=page.absolute().as_uri())


class CABLETWIN_OT_steel_gross_show(Operator):
    """Select the mark of a gross error and look at it."""

    bl_idname = "cabletwin.steel_gross_show"
    bl_label = "View Gross Error"
    bl_description = "Select the target's mark and look at it"
    bl_options = {"REGISTER", "UNDO"}

    index: bpy.props.IntProperty(name="Gross error", description="Its number in the list", min=0)

    def work(self, context: bpy.types.Context) -> None:
        """Find it and look."""
        items = context.scene.cabletwin.steel.gross
        name = items[self.index].name if self.index < len(items) else ""
        if not choose(context, context.scene, steel_collections.GROSS, name):
            raise StageError("run", "the place of this target is not known", "see it in the report")


def present_steel(context: bpy.types.Context, scene: bpy.types.Scene, folder: Path) -> None:
    """Show a steel run in a scene, and look at it.

    Raises:
        StageError: there is nothing to show.
    """
    scene.cabletwin.steel.take(show_steel(scene, folder, preferences(context).cloud_points))
    clear_startup(scene)
    look_at_all(context, scene)


def _run_folder(scene: bpy.types.Scene) -> Path:
    folder = scene.cabletwin.steel.run_folder
    if not folder:
        raise StageError("run", "no run folder is chosen", "choose one in the panel Steel structure")
    return Path(bpy.path.abspath(folder))


classes = (
    CABLETWIN_OT_steel_choose,
    CABLETWIN_OT_steel_open,
    CABLETWIN_OT_steel_run,
    CABLETWIN_OT_steel_report,
    CABLETWIN_OT_steel_gross_show,
)
