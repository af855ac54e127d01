"""The operator that picks pairs in the 3D view: a mark on one block, then the same mark on another."""

import bpy
from bpy.app.translations import pgettext_iface as translated

from pipeline.core.errors import StageError

from ..results.joined import show_blocks, show_only
from ..results.marks import show_marks, show_pending
from ..results.picking import Hit, block_objects, cast, inside, line_of_sight
from .base import Operator
from .mosaic import gap_mm
from .mosaic_pairs import CABLETWIN_OT_mosaic_remove

_HIDDEN = {"HIDDEN", "SKIP_SAVE"}


class CABLETWIN_OT_mosaic_pick(Operator):
    """Pick the same mark on two blocks, as often as wanted; ``execute`` takes the two points."""

    bl_idname = "cabletwin.mosaic_pick"
    bl_label = "Pick Pairs"
    bl_description = "Click a mark on one block, then the same mark on another; Esc or right click ends"
    bl_options = {"REGISTER", "UNDO"}

    block_a: bpy.props.StringProperty(options=_HIDDEN)
    point_a: bpy.props.FloatVectorProperty(options=_HIDDEN)
    block_b: bpy.props.StringProperty(options=_HIDDEN)
    point_b: bpy.props.FloatVectorProperty(options=_HIDDEN)

    _first: Hit | None = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A run must be shown."""
        if not context.scene.cabletwin.results.blocks:
            cls.poll_message_set("Open a run folder first")
            return False
        return True

    def work(self, context: bpy.types.Context) -> None:
        """Add the pair."""
        scene = context.scene
        known = block_objects(scene)
        for name in (self.block_a, self.block_b):
            if name not in known:
                raise StageError("mosaic", f'there is no block "{name}"', "pick on the block meshes")
        if self.block_a == self.block_b:
            raise StageError(
                "mosaic", f"both points are on {self.block_a}", "pick the partner on another block"
            )
        mosaic = scene.cabletwin.mosaic
        pair = mosaic.pairs.add()
        pair.block_a, pair.block_b = self.block_a, self.block_b
        pair.point_a, pair.point_b = self.point_a, self.point_b
        shown = scene.cabletwin.results.blocks
        pair.adjustment_a, pair.adjustment_b = (
            shown[name].adjustment if name in shown else "" for name in (self.block_a, self.block_b)
        )
        pair.residual_mm = gap_mm(scene, pair)
        mosaic.pair_index, mosaic.way = len(mosaic.pairs) - 1, "BY_HAND"
        mosaic.joins.clear()
        show_marks(scene)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Show the blocks and wait for clicks."""
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Pick in a 3D view")
            return {"CANCELLED"}
        show_blocks(context.scene)
        self._ask(context, None)
        context.window.cursor_modal_set("CROSSHAIR")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Clicks pick, Esc and the right button end, Ctrl Z takes the last point or pair back."""
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        if event.type == "Z" and event.ctrl and event.value == "PRESS":
            self._back(context)
            return {"RUNNING_MODAL"}
        over = context.area is not None and inside(context.area, event.mouse_x, event.mouse_y)
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and over:
            self._click(context, event)
            return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Leave everything as it was, but for the pairs."""
        show_only(context.scene, context.view_layer, None)
        show_marks(context.scene)
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        if context.area is not None:
            context.area.header_text_set(None)

    def _ask(self, context: bpy.types.Context, first: Hit | None) -> None:
        """Show what can be clicked now, and say so."""
        scene = context.scene
        self._first = first
        show_only(scene, context.view_layer, self._shown(scene))
        if first is None:
            text = translated("Click a mark on {}").format(
                scene.cabletwin.mosaic.block_a or translated("a block")
            )
        else:
            partner = self._partner(scene, first) or translated("another block")
            text = translated("{}: now the same mark on {}").format(first.block, partner)
        context.area.header_text_set(text)
        context.workspace.status_text_set(translated("{}    Esc: end    Ctrl Z: back").format(text))

    def _shown(self, scene: bpy.types.Scene) -> list[str] | None:
        """The blocks that can be clicked: one over the other, only the upper could be."""
        mosaic, names = scene.cabletwin.mosaic, list(block_objects(scene))
        if self._first is None:
            return [mosaic.block_a] if mosaic.block_a in names else None
        partner = self._partner(scene, self._first)
        return [partner] if partner in names else [n for n in names if n != self._first.block]

    def _partner(self, scene: bpy.types.Scene, first: Hit) -> str:
        mosaic = scene.cabletwin.mosaic
        chosen = {mosaic.block_a, mosaic.block_b} - {first.block, ""}
        return chosen.pop() if len(chosen) == 1 else ""

    def _click(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        scene = context.scene
        origin, direction = line_of_sight(context.area, event.mouse_x, event.mouse_y)
        hit = cast(scene, context.view_layer, origin, direction, self._shown(scene))
        if hit is None:
            self.report({"WARNING"}, "No block is there")
            return
        if self._first is None:
            show_pending(scene, hit.block, hit.point)
            self._ask(context, hit)
            return
        first = self._first
        # all is seen again before the step is kept, so that undoing it leaves nothing hidden
        show_only(scene, context.view_layer, None)
        self._first = None
        bpy.ops.cabletwin.mosaic_pick(
            block_a=first.block, point_a=first.point, block_b=hit.block, point_b=hit.point
        )
        # inside an operator that may be undone as a whole Blender keeps no steps by itself
        bpy.ops.ed.undo_push(message=self.bl_label)
        self._ask(context, None)

    def _back(self, context: bpy.types.Context) -> None:
        """Take the first point back, or the last pair."""
        if self._first is not None:
            show_marks(context.scene)
        elif context.scene.cabletwin.mosaic.pairs:
            show_only(context.scene, context.view_layer, None)
            last = len(context.scene.cabletwin.mosaic.pairs) - 1
            bpy.ops.cabletwin.mosaic_remove(index=last)
            bpy.ops.ed.undo_push(message=CABLETWIN_OT_mosaic_remove.bl_label)
        self._ask(context, None)


classes = (CABLETWIN_OT_mosaic_pick,)
