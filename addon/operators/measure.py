"""Operators of the measurement: stations added, removed and looked at; measuring them; what stands out."""

import math
from functools import partial

import bpy
from bpy.app.translations import pgettext_iface as translated
from mathutils import Vector

from pipeline.core.errors import StageError

from ..jobs import Job
from ..pieces import Pieces, beside
from ..properties.survey import add_station
from ..results import collections
from ..results.deviation import shows_ring
from ..results.show import show_measurement
from ..results.sketch import refresh_sketch
from ..results.stations import provisional_mm
from ..results.view import look_at
from ..segments import chosen, read_run
from .base import Operator, take_out
from .following import JobOperator
from .picking import surface_under_mouse, view_under_mouse
from .results import present_run
from .running import run_folder, start_reconstruction

_UNDOABLE = {"REGISTER", "UNDO"}
STEP_M = 0.0001
"""Places that are clicked are rounded to this."""


class CABLETWIN_OT_measure_station_add(Operator):
    """Add a station by a click on the cable, or at a position."""

    bl_idname = "cabletwin.measure_station_add"
    bl_label = "Add Station on the Cable"
    bl_description = "Click on the cable to add a station there"
    bl_options = _UNDOABLE

    position: bpy.props.FloatProperty(
        name="Position",
        description="Along the axis from the first frame",
        subtype="DISTANCE",
        unit="LENGTH",
        precision=4,
        step=1,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a cable to click on."""
        if not context.scene.cabletwin.measure.profile:
            cls.poll_message_set("Open a measured run first")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Show the cable and wait for the click."""
        collections.set_hidden(context.scene, collections.MOSAIC, False)
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("CROSSHAIR")
        self._say(context, translated("Click on the cable to add a station, Esc to leave"))
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Tell what is under the mouse; take it on a click."""
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self._leave(context, {"CANCELLED"})
        pressed = event.type == "LEFTMOUSE" and event.value == "PRESS"
        if event.type != "MOUSEMOVE" and not pressed:
            return {"PASS_THROUGH"}
        if pressed and view_under_mouse(context, event) is None:
            return self._leave(context, {"CANCELLED", "PASS_THROUGH"})
        place = surface_under_mouse(context, event, cable_meshes(context.scene))
        if place is None:
            return {"RUNNING_MODAL"} if pressed else {"PASS_THROUGH"}
        self.position = round(place.y / STEP_M) * STEP_M
        if pressed:
            self._leave(context, set())
            return self.execute(context)
        diameter_mm, _ = provisional_mm(context.scene, self.position)
        self._say(context, f"{1000 * self.position:.1f} mm    ⌀ ≈ {diameter_mm:.1f} mm")
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends or loads another file."""
        self._leave(context, set())

    def work(self, context: bpy.types.Context) -> None:
        """Append it; it shows the profile's diameter until it is measured."""
        scene = context.scene
        survey, profile = scene.cabletwin.survey, scene.cabletwin.measure.profile
        end_m = survey.travel if survey.blocks else profile[-1].position_m
        if not 0 <= self.position <= end_m:
            raise StageError(
                "measure",
                f"{self.position:.4f} m lies outside the travel",
                f"choose a place between 0 and {end_m:.4f} m",
            )
        keep_stations(scene)
        add_station(survey, self.position)
        refresh_sketch(scene)

    def _say(self, context: bpy.types.Context, text: str | None) -> None:
        """In the view's header, near the eye, and in the status bar."""
        context.workspace.status_text_set(text)
        if context.area is not None and context.area.type == "VIEW_3D":
            context.area.header_text_set(text)

    def _leave(self, context: bpy.types.Context, how: set[str]) -> set[str]:
        context.window.cursor_modal_restore()
        self._say(context, None)
        return how


class CABLETWIN_OT_measure_station_remove(Operator):
    """Take the chosen station out."""

    bl_idname = "cabletwin.measure_station_remove"
    bl_label = "Remove Station"
    bl_description = "Take the chosen station out of the survey"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        data = context.scene.cabletwin
        return len(data.survey.stations or data.results.stations) > 0

    def work(self, context: bpy.types.Context) -> None:
        """Remove it and show the one before."""
        scene = context.scene
        keep_stations(scene)
        survey = scene.cabletwin.survey
        index = min(max(survey.station_index, 0), len(survey.stations) - 1)
        survey.station_index = take_out(survey.stations, index)
        refresh_sketch(scene)


class CABLETWIN_OT_measure_station_show(Operator):
    """Turn the view to a station."""

    bl_idname = "cabletwin.measure_station_show"
    bl_label = "View Station"
    bl_description = "Turn the view to the chosen station"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        return chosen_position(context.scene) is not None

    def work(self, context: bpy.types.Context) -> None:
        """Look at the middle of its section from where one looks now."""
        y_m = chosen_position(context.scene) or 0.0
        diameter_mm, (x_mm, z_mm) = provisional_mm(context.scene, y_m)
        across_m = (diameter_mm if math.isfinite(diameter_mm) else 100.0) / 1000
        place = Vector((x_mm / 1000, y_m, z_mm / 1000)) if math.isfinite(diameter_mm) else Vector((0, y_m, 0))
        look_at(context, context.scene, place, 3.5 * across_m)


class CABLETWIN_OT_measure_feature_show(Operator):
    """Turn the view to something that stands out."""

    bl_idname = "cabletwin.measure_feature_show"
    bl_label = "View Feature"
    bl_description = "Turn the view square to this place"
    bl_options = {"REGISTER"}

    index: bpy.props.IntProperty(name="Feature", description="Its number in the list", min=0)

    def work(self, context: bpy.types.Context) -> None:
        """Look at it from outside."""
        measure = context.scene.cabletwin.measure
        if self.index >= len(measure.features):
            raise StageError(
                "measure", f"there is no feature {self.index + 1}", "choose one that is in the list"
            )
        feature = measure.features[self.index]
        turn, radius_m = math.radians(feature.azimuth_deg), measure.mean_diameter_mm / 2000
        outward = Vector((math.cos(turn), 0, -math.sin(turn)))
        place = radius_m * outward + Vector((0, feature.position_m, 0))
        look_at(context, context.scene, place, 5 * radius_m, outward)


class CABLETWIN_OT_measure_run(JobOperator):
    """Measure the stations."""

    bl_idname = "cabletwin.measure_run"
    bl_label = "Measure"
    bl_description = "Measure the survey's stations; only what rests on them is made again"
    bl_options = _UNDOABLE
    kind = "measure"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a survey, and no other job."""
        if not context.scene.cabletwin.survey.blocks:
            cls.poll_message_set("Open the survey of this run first")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """The whole chain: it finds by itself what must be made again."""
        return start_reconstruction(context)

    def show(self, context: bpy.types.Context, scene: bpy.types.Scene) -> Pieces[None]:
        """Bring in what was measured; the surface too, if that is another one."""
        folder = run_folder(scene.cabletwin.run)
        shown = chosen(folder, scene.cabletwin.run.segment)
        if shows_ring(scene, shown):
            run = yield from beside(partial(read_run, shown))
            yield from show_measurement(scene, run)
        else:
            yield from present_run(context, scene, folder)

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Say so."""
        self.report({"INFO"}, "Measured")


def keep_stations(scene: bpy.types.Scene) -> None:
    """Where the survey names no station, take over those that were measured, before they are changed."""
    survey = scene.cabletwin.survey
    if len(survey.stations):
        return
    for known in scene.cabletwin.results.stations:
        station = survey.stations.add()
        station.name, station.position = known.name, known.position_m


def chosen_position(scene: bpy.types.Scene) -> float | None:
    """Position of the station that the list shows, metres; None without stations."""
    survey, results = scene.cabletwin.survey, scene.cabletwin.results
    places = [s.position for s in survey.stations] or [s.position_m for s in results.stations]
    return places[min(max(survey.station_index, 0), len(places) - 1)] if places else None


def cable_meshes(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """What can be clicked on: the mosaic and the blocks."""
    found = [collections.existing(scene, kind) for kind in (collections.MOSAIC, collections.BLOCKS)]
    return [item for each in found if each is not None for item in each.objects if item.type == "MESH"]


classes = (
    CABLETWIN_OT_measure_station_add,
    CABLETWIN_OT_measure_station_remove,
    CABLETWIN_OT_measure_station_show,
    CABLETWIN_OT_measure_feature_show,
    CABLETWIN_OT_measure_run,
)
