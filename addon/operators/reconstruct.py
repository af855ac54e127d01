"""Operators of the reconstruction: run the pipeline in a process of its own, cancel it, see its log."""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError

from ..jobs import Job
from ..pieces import Pieces
from .base import Operator
from .following import JobOperator
from .results import present_run
from .running import run_folder, start_reconstruction


class CABLETWIN_OT_reconstruct_run(JobOperator):
    """Reconstruct the cable."""

    bl_idname = "cabletwin.reconstruct_run"
    bl_label = "Reconstruct"
    bl_description = "Run the whole chain in the background; what is finished in the run folder is kept"
    bl_options = {"UNDO"}
    kind = "reconstruct"

    again: bpy.props.BoolProperty(
        name="From the stage",
        description="Make the chosen stage and all after it again",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be blocks, and no other job."""
        if not context.scene.cabletwin.survey.blocks:
            cls.poll_message_set("The survey has no blocks")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Save the survey and start the pipeline on it."""
        again = ("--from", context.scene.cabletwin.run.start) if self.again else ()
        return start_reconstruction(context, *again)

    def show(self, context: bpy.types.Context, scene: bpy.types.Scene) -> Pieces[None]:
        """Bring the results in."""
        yield from present_run(context, scene, run_folder(scene.cabletwin.run))

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Say so."""
        self.report({"INFO"}, "Reconstructed")


class CABLETWIN_OT_reconstruct_cancel(bpy.types.Operator):
    """Ask the running job to stop."""

    bl_idname = "cabletwin.reconstruct_cancel"
    bl_label = "Cancel"
    bl_description = "Stop the running job; what is finished is kept"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Something must run, and not be asked twice."""
        job = context.window_manager.cabletwin_job
        return job.running and not job.cancelling

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Leave the word; whoever follows the job stops it."""
        context.window_manager.cabletwin_job.tell(cancelling=True)
        return {"FINISHED"}


class CABLETWIN_OT_reconstruct_log(Operator):
    """Open the log of the last job in the text editor."""

    bl_idname = "cabletwin.reconstruct_log"
    bl_label = "Show Log"
    bl_description = "Open the log of the last job in a text editor"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a log."""
        return bool(context.window_manager.cabletwin_job.log)

    def work(self, context: bpy.types.Context) -> None:
        """Load it and open a window for it."""
        path = Path(context.window_manager.cabletwin_job.log)
        if not path.is_file():
            raise StageError("run", f"{path} is gone", "run again")
        bpy.ops.wm.window_new()
        area = context.window_manager.windows[-1].screen.areas[0]
        area.type = "TEXT_EDITOR"
        area.spaces.active.text = bpy.data.texts.load(str(path))


classes = (CABLETWIN_OT_reconstruct_run, CABLETWIN_OT_reconstruct_cancel, CABLETWIN_OT_reconstruct_log)
