"""Operators of the lens: its preview, its estimate from the cable's edges, calibration with a chessboard."""

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.app.translations import pgettext_rpt as translated

from pipeline.cable.survey_writer import write_survey
from pipeline.core.errors import StageError

from ..gather import gather_blocks
from ..jobs import Job, pipeline_command
from ..library import python_executable
from ..properties.block import CableTwinBlock
from ..results.lens_view import editors, refresh_preview
from .base import Operator
from .following import JobOperator


class CABLETWIN_OT_lens_show(Operator):
    """Show a frame before and after the correction."""

    bl_idname = "cabletwin.lens_show"
    bl_label = "Show Preview"
    bl_description = "Show a frame before and after the correction, side by side in a window of their own"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown."""
        return _has_block(cls, context)

    def work(self, context: bpy.types.Context) -> None:
        """Draw the pictures, and open a window where none shows them."""
        scene = context.scene
        refresh_preview(scene)
        if not bpy.app.background and not editors(scene):
            _open_window(context)


class CABLETWIN_OT_lens_estimate(JobOperator):
    """Estimate lambda from the edges of the cable."""

    bl_idname = "cabletwin.lens_estimate"
    bl_label = "Estimate"
    bl_description = "Estimate lambda from the edges of the cable in the block's video, in the background"
    bl_options = {"UNDO"}
    kind = "lens"
    shares = {"frames": 4.0, "lens": 1.0}

    every: bpy.props.BoolProperty(
        name="All blocks",
        description="Estimate the lambda of every block from its own video",
        options={"SKIP_SAVE"},
    )
    _blocks: tuple[str, ...] = ()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown, and no other job run."""
        return _has_block(cls, context) and super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Write the blocks into a survey of their own and have their edges looked at."""
        survey = context.scene.cabletwin.survey
        self._blocks = tuple(b.name for b in survey.blocks) if self.every else (survey.block().name,)
        # other blocks may still be without a video: they are left out
        values = gather_blocks(context.scene, *self._blocks)
        file = _job_folder() / "survey.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        write_survey(values, file)
        words = [word for name in self._blocks for word in ("--block", name)]
        return _start("lens", str(file), *words), self._blocks

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Put lambda and its sigma into the blocks: both are saved, and each run starts from them."""
        found = _found()
        for name in self._blocks:
            block, lens = _block(scene, name), found[name]["lens"]
            # trusting the focal length would trust lambda too: then each run estimates it in the same way
            block.lambda_known = not block.calibrated
            block.lambda_radius = lens["lambda_radius"]
            _set_lambda(block, lens, "EDGES")
            self.report(
                {"INFO"},
                translated("{}: lambda {:.5f} ± {:.5f}").format(
                    name, lens["division_lambda"], lens["lambda_sigma"]
                ),
            )


class CABLETWIN_OT_lens_chessboard(JobOperator):
    """Calibrate the lens with pictures of a chessboard."""

    bl_idname = "cabletwin.lens_chessboard"
    bl_label = "Calibrate"
    bl_description = "Find focal length, principal point and lambda from pictures of a chessboard"
    bl_options = {"UNDO"}
    kind = "lens"
    shares = {"lens": 1.0}

    every: bpy.props.BoolProperty(
        name="All blocks",
        description="Give every block this lens: for cameras that are alike",
        options={"SKIP_SAVE"},
    )
    _blocks: tuple[str, ...] = ()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown, and no other job run."""
        return _has_block(cls, context) and super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Have the corners found."""
        scene = context.scene
        survey, view = scene.cabletwin.survey, scene.cabletwin.lens
        if not view.board_folder:
            raise StageError("lens", "no pictures of a chessboard are chosen", "choose their folder")
        self._blocks = tuple(b.name for b in survey.blocks) if self.every else (survey.block().name,)
        columns, rows = view.board_corners
        folder = bpy.path.abspath(view.board_folder)
        return _start("lens", folder, "--chessboard", f"{columns}x{rows}"), ()

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Put the lens into the block as a calibrated one."""
        found = _found()
        lens = found["lens"]
        for name in self._blocks:
            block = _block(scene, name)
            block.focal_in, block.focal_px = "PX", lens["focal_px"]
            block.use_principal_point, block.principal_point_px = True, lens["principal_point_px"]
            block.lambda_radius, block.lambda_known, block.calibrated = lens["lambda_radius"], True, True
            _set_lambda(block, lens, "BOARD")
        self.report(
            {"INFO"},
            translated("{} of {} pictures used, corners to {:.2f} px").format(
                len(found["used"]), len(found["used"]) + len(found["unused"]), found["noise_px"]
            ),
        )


def _has_block(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    if context.scene.cabletwin.survey.block() is None:
        cls.poll_message_set("The survey has no blocks")
        return False
    return True


def _job_folder() -> Path:
    """Where a job of this area works; gone when Blender ends."""
    return Path(bpy.app.tempdir) / "cabletwin_lens"


def _start(*words: str) -> Job:
    folder = _job_folder()
    (folder / "found.json").unlink(missing_ok=True)
    more = ("--json", str(folder / "found.json"), "--events", "json")
    return Job(pipeline_command(python_executable(), *words, *more), folder / "log.jsonl")


def _found() -> Mapping[str, Any]:
    found: Mapping[str, Any] = json.loads((_job_folder() / "found.json").read_text(encoding="utf-8"))
    return found


def _block(scene: bpy.types.Scene, name: str) -> CableTwinBlock:
    block = scene.cabletwin.survey.blocks.get(name)
    if block is None:
        raise StageError("lens", f"the survey has no block {name} any more", "estimate its lens again")
    return block


def _set_lambda(block: CableTwinBlock, lens: Mapping[str, Any], origin: str) -> None:
    block.division_lambda = lens["division_lambda"]
    # a lambda that is set forgets where the last one came from
    block.lambda_sigma, block.lambda_from = lens["lambda_sigma"], origin


def _open_window(context: bpy.types.Context) -> None:
    """Two image editors side by side in a window of their own: nobody's layout is touched."""
    bpy.ops.wm.window_new()
    window = context.window_manager.windows[-1]
    area = window.screen.areas[0]
    area.type = "IMAGE_EDITOR"
    with context.temp_override(window=window, area=area, region=_region(area)):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    # which of the two lies on the left, and how large they are, is known once they have been laid out
    bpy.app.timers.register(partial(_fill_window, window.screen.name, context.scene.name), first_interval=0.1)


def _fill_window(screen: str, scene: str) -> None:
    """Before on the left, after on the right, whole."""
    window = next((w for w in bpy.context.window_manager.windows if w.screen.name == screen), None)
    if window is None or scene not in bpy.data.scenes:
        return
    view = bpy.data.scenes[scene].cabletwin.lens
    areas = sorted((a for a in window.screen.areas if a.type == "IMAGE_EDITOR"), key=lambda a: a.x)
    for area, image in zip(areas, (view.before, view.after), strict=False):
        area.spaces.active.image = image
        with bpy.context.temp_override(window=window, area=area, region=_region(area)):
            bpy.ops.image.view_all(fit_view=True)


def _region(area: bpy.types.Area) -> bpy.types.Region:
    return next(region for region in area.regions if region.type == "WINDOW")


classes = (CABLETWIN_OT_lens_show, CABLETWIN_OT_lens_estimate, CABLETWIN_OT_lens_chessboard)
