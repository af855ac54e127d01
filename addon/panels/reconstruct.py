"""The panel *Reconstruct*: run, progress, cancel, and what went wrong."""

from collections.abc import Mapping

import bpy
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

from ..properties.job import SHOWING
from ..properties.run import STAGES
from .base import Panel, aligned, sentence

_STAGE_NAMES = {name: label for name, label, _ in STAGES} | {
    "render": n_("Rendering"),
    SHOWING: n_("Bringing in the results"),
}


class CABLETWIN_PT_reconstruct(Panel):
    """Reconstruct."""

    bl_idname = "CABLETWIN_PT_reconstruct"
    bl_label = "Reconstruct"
    bl_order = 3

    def draw(self, context: bpy.types.Context) -> None:
        """Settings and the button, or the progress of what runs."""
        job, run = context.window_manager.cabletwin_job, context.scene.cabletwin.run
        mine = job.kind != "steel"  # that one is told in its own panel
        settings = aligned(self.layout)
        settings.enabled = not job.running
        settings.prop(run, "folder")
        settings.prop(run, "adjust")
        if job.running and mine:
            draw_progress(self.layout, job)
        else:
            row = self.layout.row()
            row.scale_y = 1.4
            row.operator("cabletwin.reconstruct_run", icon="PLAY")
            row = self.layout.row(align=True)
            row.operator("cabletwin.reconstruct_run", text="Again from", icon="FILE_REFRESH").again = True
            row.prop(run, "start", text="")
        if job.failure and mine:
            sentence(self.layout.box(), job.failure, "ERROR")
        if job.log and mine:
            self.layout.operator("cabletwin.reconstruct_log", icon="TEXT")


def draw_reconstruction(layout: bpy.types.UILayout, context: bpy.types.Context) -> bool:
    """The progress of a reconstruction that another panel started; False where none runs."""
    job = context.window_manager.cabletwin_job
    if not (job.running and job.kind == "reconstruct"):
        return False
    draw_progress(layout, job)
    return True


def draw_progress(
    layout: bpy.types.UILayout, job: bpy.types.PropertyGroup, names: Mapping[str, str] = _STAGE_NAMES
) -> None:
    """A bar with stage, by its name, and time left, and the way to stop."""
    stage = translated(names.get(job.stage, job.stage)) if job.stage else translated("Starting")
    where = " · ".join(word for word in (stage, job.part, job.block) if word)
    layout.progress(factor=job.fraction, text=f"{round(100 * job.fraction)} %  {where}", type="BAR")
    row = layout.row()
    if job.cancelling:
        row.label(text="Cancelling", icon="CANCEL")
        return
    left = job.seconds_left
    if left >= 0:
        row.label(
            text=translated("About {} left").format(f"{int(left // 60)}:{int(left % 60):02d}"),
            translate=False,
        )
    row.operator("cabletwin.reconstruct_cancel", icon="CANCEL")


classes = (CABLETWIN_PT_reconstruct,)
