"""Operators of the area *synthesise*: cable and ring from the library, and a survey rendered from them."""

import os
from pathlib import Path

import bpy

from pipeline.core.errors import StageError

from ..apply import open_survey
from ..asset_library import append_object, is_known, make_known
from ..gather_spec import gather_spec, spec_toml
from ..jobs import Job
from ..library import python_executable
from ..results import collections
from ..results.ring import add_ring, refresh_ring
from ..results.sketch import refresh_sketch
from ..results.view import clear_startup, frame
from ..synthetic_cable import refresh_sheath, scene_cable
from .base import Operator
from .following import JobOperator

_UNDOABLE = {"REGISTER", "UNDO"}


class CABLETWIN_OT_synthesise_add_cable(Operator):
    """Put the library's cable into the scene."""

    bl_idname = "cabletwin.synthesise_add_cable"
    bl_label = "Add Cable"
    bl_description = "Put the library's cable into the survey's frame"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Append it, choose it."""
        scene = context.scene
        cable = append_object("Cable")
        collections.collection(scene, collections.CABLE).objects.link(cable)
        scene.cabletwin.synthesise.cable = cable
        refresh_sheath(scene)
        refresh_ring(scene)
        _choose(context, cable)
        _look(context)


class CABLETWIN_OT_synthesise_add_ring(Operator):
    """Put the library's ring into the scene."""

    bl_idname = "cabletwin.synthesise_add_ring"
    bl_label = "Add Ring"
    bl_description = (
        "Show the robot's ring with its cameras and lamps; it moves through the frames of the scene"
    )
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Append it in place of one that is there."""
        _choose(context, add_ring(context.scene))
        _look(context)


class CABLETWIN_OT_synthesise_add_library(Operator):
    """Name the library in the preferences."""

    bl_idname = "cabletwin.synthesise_add_library"
    bl_label = "Add Asset Library"
    bl_description = "Name CableTwin's asset library in the preferences: the Asset Browser then shows it"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Once is enough."""
        if is_known(context):
            cls.poll_message_set("The Asset Browser knows it already")
            return False
        return True

    def work(self, context: bpy.types.Context) -> None:
        """Add it."""
        make_known(context)


class CABLETWIN_OT_synthesise_render(JobOperator):
    """Render a survey from the scene."""

    bl_idname = "cabletwin.synthesise_render"
    bl_label = "Render Survey"
    bl_description = "Render what the robot would film, in the background, and open it as a survey"
    bl_options = {"REGISTER"}
    kind = "synthesise"
    shares = {"render": 1.0}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a cable, and no other job."""
        if scene_cable(context.scene) is None:
            cls.poll_message_set("The scene has no cable")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Write SPEC.toml and start synth on it."""
        scene = context.scene
        text, folder = spec_toml(gather_spec(scene)), survey_folder(scene)
        spec = folder / "spec.toml"
        _write(spec, text)
        # synth counts its frames over all blocks
        return Job(render_command(spec, folder), folder / "render.jsonl", _apart()), ()

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Open the survey, with its truth."""
        folder = survey_folder(scene)
        open_survey(scene, folder / "survey.toml")
        run = scene.cabletwin.run
        run.folder, run.truth = str(folder / "run"), str(folder / "truth.json")
        refresh_sketch(scene)
        self.report({"INFO"}, "Rendered")


def survey_folder(scene: bpy.types.Scene) -> Path:
    """The absolute folder of the rendered survey.

    Raises:
        StageError: none is chosen.
    """
    chosen = scene.cabletwin.synthesise.folder
    if not chosen:
        raise StageError("synthesise", "no survey folder is chosen", "choose one in the panel Synthesise")
    return Path(bpy.path.abspath(chosen))


def render_command(spec: Path, out: Path) -> list[str]:
    """Synth in a Blender of its own without a window; under the package bpy, in its Python."""
    if bpy.app.binary_path:
        script = Path(__file__).resolve().parents[1] / "synth" / "blender" / "__main__.py"
        start = [bpy.app.binary_path, "--background", "--factory-startup", "--python", str(script), "--"]
    else:
        start = [str(python_executable()), "-m", "synth.blender"]
    return [*start, str(spec), str(out)]


def _apart() -> dict[str, str]:
    """A user folder for that Blender: with factory settings it would clear this one's of our packages."""
    folder = bpy.utils.extension_path_user(__package__.rpartition(".")[0], path="renderer", create=True)
    return {"BLENDER_USER_RESOURCES": folder}


def _write(path: Path, text: str) -> None:
    """Write a file whole or not at all.

    Raises:
        StageError: the place cannot be written.
    """
    part = path.with_suffix(".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise StageError(
            "synthesise", f"{path} cannot be written ({error.strerror})", "choose another survey folder"
        ) from error


def _look(context: bpy.types.Context) -> None:
    """Turn the views to what the library has brought."""
    clear_startup(context.scene)
    context.view_layer.update()  # the modifiers' shapes count
    frame(context, context.scene, collections.CABLE, collections.RING)


def _choose(context: bpy.types.Context, item: bpy.types.Object) -> None:
    """Select one object alone."""
    for other in context.view_layer.objects:
        other.select_set(False)
    item.select_set(True)
    context.view_layer.objects.active = item


classes = (
    CABLETWIN_OT_synthesise_add_cable,
    CABLETWIN_OT_synthesise_add_ring,
    CABLETWIN_OT_synthesise_add_library,
    CABLETWIN_OT_synthesise_render,
)
