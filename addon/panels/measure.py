"""The panel *Measure*: stations with their diameters, comparison with the truth, relief, colours."""

import bpy
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

from ..properties.measure import measured_at
from .base import Panel, RowList, aligned, sentence
from .reconstruct import draw_progress

_KINDS = {"bulge": n_("Bulge"), "dent": n_("Dent"), "ridge": n_("Ridge")}
_COLUMNS = (0.13, 0.45)
"""Shares of a row: name; of the rest, position."""
_SIGNS = {"dent": "−"}


class CABLETWIN_UL_measured(RowList):
    """Stations of the survey, or where it names none those that were measured, with their diameters."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """Name, position, diameter with its sigma."""
        data = item.id_data.cabletwin
        own = hasattr(item, "position")
        split = row.split(factor=_COLUMNS[0])
        if own:
            split.prop(item, "name", text="", emboss=False)
        else:
            split.label(text=item.name, translate=False)
        split = split.split(factor=_COLUMNS[1])
        if own:
            split.prop(item, "position", text="", emboss=False)
        else:
            split.label(text=f"{item.position_m:.3f} m", translate=False)
        found = measured_at(data.results, item.position) if own else item
        right = split.row()
        right.alignment = "RIGHT"
        right.label(text=diameter_text(item, found), translate=False)


class CABLETWIN_PT_measure(Panel):
    """Measure."""

    bl_idname = "CABLETWIN_PT_measure"
    bl_label = "Measure"
    bl_order = 7

    def draw(self, context: bpy.types.Context) -> None:
        """The stations, what can be done with them, and the chosen one."""
        data, job = context.scene.cabletwin, context.window_manager.cabletwin_job
        if not data.measure.profile and not data.survey.stations:
            self.layout.label(text="Nothing is measured yet", icon="INFO")
            return
        _stations(self.layout, data)
        row = self.layout.row(align=True)
        row.operator("cabletwin.measure_station_add", text="Add", icon="RESTRICT_SELECT_OFF")
        row.operator("cabletwin.measure_station_remove", text="Remove", icon="REMOVE")
        row.operator("cabletwin.measure_station_show", text="View", icon="VIEWZOOM")
        if job.running and job.kind == "measure":
            draw_progress(self.layout, job)
        else:
            row = self.layout.row()
            row.scale_y = 1.4
            row.operator("cabletwin.measure_run", icon="DRIVER_DISTANCE")
        if job.failure and job.kind == "measure":
            sentence(self.layout.box(), job.failure, "ERROR")


class CABLETWIN_PT_measure_chosen(Panel):
    """The chosen station."""

    bl_label = "Chosen station"
    bl_parent_id = "CABLETWIN_PT_measure"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        return _chosen(context.scene.cabletwin) is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Every figure of it."""
        data = context.scene.cabletwin
        item = _chosen(data)
        if item is None:
            return
        found = measured_at(data.results, item.position) if hasattr(item, "position") else item
        column = self.layout.column(align=True)
        if found is None:
            column.label(text="From the profile; press Measure", icon="INFO")
            _figure(column, translated("Diameter"), f"{diameter_text(item, None)} mm")
            return
        _figure(column, translated("Diameter"), f"{found.diameter_mm:.3f} ± {found.sigma_mm:.3f} mm")
        _figure(column, translated("Smallest"), f"{found.min_mm:.3f} mm")
        _figure(column, translated("Largest"), f"{found.max_mm:.3f} mm")
        _figure(column, translated("Seen"), f"{found.coverage_deg:.0f}°")
        if found.truth_mm >= 0:
            _figure(column, translated("Truth"), f"{found.truth_mm:.3f} mm")
            _figure(column, translated("Difference"), f"{found.difference_mm:+.3f} mm")


class CABLETWIN_PT_measure_truth(Panel):
    """Comparison with the truth."""

    bl_label = "Against the truth"
    bl_parent_id = "CABLETWIN_PT_measure"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Something must be measured."""
        return len(context.scene.cabletwin.results.stations) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """A row for each station that has a truth, and the mean absolute error."""
        data = context.scene.cabletwin
        aligned(self.layout).prop(data.run, "truth")
        results = data.results
        if not results.has_truth:
            self.layout.label(text="Choose a truth.json and press Measure", icon="INFO")
            return
        box = self.layout.box().column(align=True)
        _row(box, *(translated(t) for t in (n_("Station"), n_("Truth"), n_("Difference"))))
        for station in results.stations:
            if station.truth_mm >= 0:
                off = f"{station.difference_mm:+.3f}".replace("-", "−")
                _row(box, station.name, f"{station.truth_mm:.3f}", off)
        _figure(self.layout, translated("Mean absolute error"), f"{results.mean_absolute_error_mm:.3f} mm")


class CABLETWIN_PT_measure_relief(Panel):
    """What stands out of the surface."""

    bl_label = "Relief"
    bl_parent_id = "CABLETWIN_PT_measure"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Something must be measured."""
        return len(context.scene.cabletwin.measure.profile) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """A button for each feature, which turns the view to it."""
        features = context.scene.cabletwin.measure.features
        if not features:
            self.layout.label(text="Nothing stands out", icon="CHECKMARK")
            return
        column = self.layout.column(align=True)
        for index, item in enumerate(features):
            kind = translated(_KINDS[item.kind]) if item.kind in _KINDS else item.kind
            height = f"{_SIGNS.get(item.kind, '+')}{item.height_mm:.2f} mm"
            azimuth = f"{item.azimuth_deg:.0f}°".replace("-", "−")
            text = f"{kind} {height}  {item.position_m:.3f} m  {azimuth}"
            column.operator(
                "cabletwin.measure_feature_show", text=text, icon="VIEWZOOM", translate=False
            ).index = index


class CABLETWIN_PT_measure_display(Panel):
    """What the 3D view shows."""

    bl_label = "Display"
    bl_parent_id = "CABLETWIN_PT_measure"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Something must be measured."""
        return len(context.scene.cabletwin.measure.profile) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """How sections are drawn; what the surface's colours show, and over what range."""
        measure = context.scene.cabletwin.measure
        column = aligned(self.layout)
        column.prop(measure, "factor")
        column.prop(measure, "colour_by")
        ranged = column.column()
        ranged.enabled = measure.colour_by != "TEXTURE"
        ranged.prop(measure, "limit_mm")


def diameter_text(station: bpy.types.PropertyGroup, found: bpy.types.PropertyGroup | None) -> str:
    """Diameter and sigma, or where it is not measured about what the profile says."""
    if found is not None:
        return f"{found.diameter_mm:.3f} ± {found.sigma_mm:.3f}"
    return f"≈ {station.provisional_mm:.1f}" if station.provisional_mm > 0 else "–"


def _stations(layout: bpy.types.UILayout, data: bpy.types.PropertyGroup) -> None:
    head = layout.row().split(factor=_COLUMNS[0])
    head.label(text="")
    rest = head.split(factor=_COLUMNS[1])
    rest.label(text="Position")
    right = rest.row()
    right.alignment = "RIGHT"
    right.label(text="Diameter (mm)")
    source = data.survey if data.survey.stations else data.results
    layout.template_list(
        "CABLETWIN_UL_measured", "", source, "stations", data.survey, "station_index", rows=4
    )


def _chosen(data: bpy.types.PropertyGroup) -> bpy.types.PropertyGroup | None:
    items = data.survey.stations or data.results.stations
    return items[min(max(data.survey.station_index, 0), len(items) - 1)] if len(items) else None


def _figure(layout: bpy.types.UILayout, name: str, text: str) -> None:
    """A name on the left and its figure on the right."""
    row = layout.row()
    row.label(text=name, translate=False)
    right = row.row()
    right.alignment = "RIGHT"
    right.label(text=text, translate=False)


def _row(layout: bpy.types.UILayout, first: str, second: str, third: str) -> None:
    row = layout.split(factor=0.36)
    row.label(text=first, translate=False)
    # a row would give each column what its text needs, so that a heading stands beside its figures
    cells = row.split(factor=0.44)
    for text in (second, third):
        cell = cells.row()
        cell.alignment = "RIGHT"
        cell.label(text=text, translate=False)


classes = (
    CABLETWIN_UL_measured,
    CABLETWIN_PT_measure,
    CABLETWIN_PT_measure_chosen,
    CABLETWIN_PT_measure_display,
    CABLETWIN_PT_measure_relief,
    CABLETWIN_PT_measure_truth,
)
