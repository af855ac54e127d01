"""The panel *Synthesise*: a cable from the library, its ring and look, and the survey rendered."""

import bpy
from bpy.app.translations import pgettext_iface as translated

from ..render_cost import render_seconds
from ..synthetic_cable import asset_modifier, field, scene_cable, sockets
from .base import Panel, aligned, sentence
from .reconstruct import draw_progress


class CABLETWIN_PT_synthesise(Panel):
    """Synthesise."""

    bl_idname = "CABLETWIN_PT_synthesise"
    bl_label = "Synthesise"
    bl_order = 9

    def draw(self, context: bpy.types.Context) -> None:
        """Where it goes, what it costs, the button or the progress."""
        settings, job = context.scene.cabletwin.synthesise, context.window_manager.cabletwin_job
        row = self.layout.row(align=True)
        row.operator("cabletwin.synthesise_add_cable", icon="MESH_CYLINDER")
        row.operator("cabletwin.synthesise_add_ring", icon="CAMERA_DATA")
        self.layout.operator("cabletwin.synthesise_add_library", icon="ASSET_MANAGER")
        cable = scene_cable(context.scene)
        if cable is None:
            sentence(self.layout, translated("Add a cable, or drag one from the Asset Browser"), "INFO")
            return
        column = aligned(self.layout)
        column.enabled = not job.running
        column.prop(settings, "name")
        column.prop(settings, "folder")
        column.prop(settings, "seed")
        frames = settings.cameras * settings.frames
        minutes = max(round(render_seconds(context.scene) / 60), 1)
        cost = translated("{frames} frames, about {minutes} min").format(frames=frames, minutes=minutes)
        self.layout.label(text=cost, icon="TIME", translate=False)
        if job.running and job.kind == "synthesise":
            draw_progress(self.layout, job)
        else:
            row = self.layout.row()
            row.scale_y = 1.4
            row.operator("cabletwin.synthesise_render", icon="RENDER_ANIMATION")
        if job.failure and job.kind == "synthesise":
            sentence(self.layout.box(), job.failure, "ERROR")


class _SubPanel(Panel):
    """A part of the settings, shown where there is a cable."""

    bl_parent_id = "CABLETWIN_PT_synthesise"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a cable."""
        return scene_cable(context.scene) is not None


class CABLETWIN_PT_synthesise_cable(_SubPanel):
    """The cable's shape: the inputs of its modifier."""

    bl_label = "Shape of the cable"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        """The chosen cable, and the inputs by their panels."""
        aligned(self.layout).prop(context.scene.cabletwin.synthesise, "cable")
        cable = scene_cable(context.scene)
        modifier = asset_modifier(cable, "cable") if cable else None
        if modifier is None:
            return
        bodies = {"": aligned(self.layout)}
        for panel, socket in sockets(modifier):
            if panel not in bodies:
                header, body = self.layout.panel(f"cabletwin_cable_{panel}", default_closed=True)
                if socket.is_panel_toggle:
                    header.prop(field(modifier, socket), "value", text=panel)
                else:
                    header.label(text=panel)
                bodies[panel] = aligned(body) if body else None
                if body and socket.is_panel_toggle:
                    bodies[panel].active = field(modifier, socket).value
            if bodies[panel] and not getattr(socket, "is_panel_toggle", False):
                bodies[panel].prop(field(modifier, socket), "value", text=socket.name)


class CABLETWIN_PT_synthesise_ring(_SubPanel):
    """Ring and lens."""

    bl_label = "Ring and lens"

    def draw(self, context: bpy.types.Context) -> None:
        """What the ring looks like and what its cameras see."""
        settings = context.scene.cabletwin.synthesise
        column = aligned(self.layout)
        for key in ("cameras", "standoff", "frames", "travel_in_image", "synchronised"):
            column.prop(settings, key)
        column.separator()
        column.prop(settings, "focal_px")
        sizes = column.column(align=True)
        sizes.prop(settings, "width_px")
        sizes.prop(settings, "height_px")
        for key in ("division_lambda", "lambda_radius", "focal_spread_percent"):
            column.prop(settings, key)


class CABLETWIN_PT_synthesise_motion(_SubPanel):
    """Motion of the ring."""

    bl_label = "Motion"

    def draw(self, context: bpy.types.Context) -> None:
        """Sway, wander, mounting."""
        column = aligned(self.layout)
        for key in ("sway", "sway_mm", "speed_wander_mm", "mounting", "mounting_mm"):
            column.prop(context.scene.cabletwin.synthesise, key)


class CABLETWIN_PT_synthesise_sheath(_SubPanel):
    """What the cable looks like."""

    bl_label = "Sheath and light"

    def draw(self, context: bpy.types.Context) -> None:
        """Strengths and lamps."""
        settings = context.scene.cabletwin.synthesise
        column = aligned(self.layout)
        column.prop(settings, "kind")
        for key in ("grain", "dirt", "streaks", "scratches", "speckle", "mottling", "gloss"):
            column.prop(settings, key, slider=True)
        column.prop(settings, "texel_mm")
        column.separator()
        column.prop(settings, "lamp_strength")
        column.prop(settings, "daylight")


class CABLETWIN_PT_synthesise_sensor(_SubPanel):
    """From light to files."""

    bl_label = "Sensor"

    def draw(self, context: bpy.types.Context) -> None:
        """Exposure, shutter, files."""
        settings = context.scene.cabletwin.synthesise
        column = aligned(self.layout)
        for key in ("exposure", "noise", "motion_blur_mm", "readout_share", "samples", "output"):
            column.prop(settings, key)


class CABLETWIN_PT_synthesise_claims(_SubPanel):
    """What the survey will say, which need not be the truth."""

    bl_label = "What the survey states"

    def draw(self, context: bpy.types.Context) -> None:
        """Calibration and errors."""
        column = aligned(self.layout)
        for key in ("calibrated", "lambda_given", "focal_error_percent", "travel_error_percent"):
            column.prop(context.scene.cabletwin.synthesise, key)


classes = (
    CABLETWIN_PT_synthesise,
    CABLETWIN_PT_synthesise_cable,
    CABLETWIN_PT_synthesise_ring,
    CABLETWIN_PT_synthesise_motion,
    CABLETWIN_PT_synthesise_sheath,
    CABLETWIN_PT_synthesise_sensor,
    CABLETWIN_PT_synthesise_claims,
)
