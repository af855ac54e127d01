"""Operators of the crop: preview, apply, reset."""

import bpy

from ..gather import write_crop
from ..jobs import Job
from ..pieces import Pieces
from ..results.crop_preview import begin_preview, check_crop, end_preview, refresh_preview
from .base import Operator
from .following import JobOperator
from .results import present_run
from .running import run_folder, start_reconstruction

_UNDOABLE = {"REGISTER", "UNDO"}
_OPTIONS = ("incidence", "least_score", "fringe", "use_start", "start", "use_end", "end")


class CABLETWIN_OT_crop_preview(Operator):
    """Show what the crop keeps and what it cuts, or stop that."""

    bl_idname = "cabletwin.crop_preview"
    bl_label = "Preview"
    bl_description = "Show the whole blocks with what would be cut in red, live while options change"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A run must be shown."""
        if not context.scene.cabletwin.results.blocks:
            cls.poll_message_set("Open a run folder first")
            return False
        return True

    def work(self, context: bpy.types.Context) -> None:
        """On or off."""
        if context.scene.cabletwin.crop.previewing:
            end_preview(context.scene)
        else:
            begin_preview(context.scene)


class CABLETWIN_OT_crop_reset(Operator):
    """Go back to the options that the pipeline starts with."""

    bl_idname = "cabletwin.crop_reset"
    bl_label = "Reset"
    bl_description = "Go back to the options that the pipeline starts with"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Reset the options; the preview follows."""
        crop = context.scene.cabletwin.crop
        for key in _OPTIONS:
            crop.property_unset(key)
        if crop.previewing:
            refresh_preview(context.scene)


class CABLETWIN_OT_crop_apply(JobOperator):
    """Crop the blocks so, and make all that rests on it again."""

    bl_idname = "cabletwin.crop_apply"
    bl_label = "Apply"
    bl_description = "Write the options to the survey and make again what rests on the crop"
    bl_options = _UNDOABLE
    kind = "reconstruct"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be blocks, and no other job."""
        if not context.scene.cabletwin.survey.blocks:
            cls.poll_message_set("The survey has no blocks")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Refuse what the pipeline would refuse, then write and start."""
        check_crop(context.scene)
        write_crop(context.scene)
        return start_reconstruction(context)

    def show(self, context: bpy.types.Context, scene: bpy.types.Scene) -> Pieces[None]:
        """Bring the new results in, in place of the preview."""
        yield from present_run(context, scene, run_folder(scene.cabletwin.run))

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Say so."""
        self.report({"INFO"}, "Cropped")


classes = (CABLETWIN_OT_crop_preview, CABLETWIN_OT_crop_reset, CABLETWIN_OT_crop_apply)
