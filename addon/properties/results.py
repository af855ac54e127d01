"""What the panels show of a run that was opened: filled once, when it is opened, and never while drawing."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from pipeline.opened import OpenedRun


FIGURES = ("position_m", "diameter_mm", "sigma_mm", "min_mm", "max_mm", "coverage_deg")
"""Of a station, as the report names them."""


class CableTwinBlockResult(bpy.types.PropertyGroup):
    """A block's figures; its ``name`` is the block's."""

    images: bpy.props.IntProperty()
    calibrated: bpy.props.IntProperty()
    reprojection_px: bpy.props.FloatProperty(default=-1)
    focal_px: bpy.props.FloatProperty(default=-1)
    division_lambda: bpy.props.FloatProperty()
    adjustment: bpy.props.StringProperty(description="Stamp of the adjustment that placed the block")


class CableTwinStationResult(bpy.types.PropertyGroup):
    """A station's figures; its ``name`` is the station's."""

    position_m: bpy.props.FloatProperty()
    diameter_mm: bpy.props.FloatProperty()
    sigma_mm: bpy.props.FloatProperty()
    min_mm: bpy.props.FloatProperty()
    max_mm: bpy.props.FloatProperty()
    coverage_deg: bpy.props.FloatProperty()
    truth_mm: bpy.props.FloatProperty(default=-1)
    difference_mm: bpy.props.FloatProperty()


class CableTwinResults(bpy.types.PropertyGroup):
    """The run that the scene shows."""

    folder: bpy.props.StringProperty(subtype="DIR_PATH")
    segments: bpy.props.IntProperty(description="How many segments the run has; 0 where it was not cut")
    finished: bpy.props.BoolProperty(description="The report is there")
    blocks: bpy.props.CollectionProperty(type=CableTwinBlockResult)
    block_index: bpy.props.IntProperty(name="Block", description="The block that is shown")
    stations: bpy.props.CollectionProperty(type=CableTwinStationResult)
    station_index: bpy.props.IntProperty(name="Station", description="The station that is shown")
    has_truth: bpy.props.BoolProperty()
    mean_absolute_error_mm: bpy.props.FloatProperty()
    warnings: bpy.props.StringProperty(description="One sentence a line")

    def forget(self) -> None:
        """No run is shown."""
        for key in ("folder", "finished", "blocks", "stations", "has_truth", "warnings"):
            self.property_unset(key)

    def take(self, run: "OpenedRun") -> None:
        """Keep what the panels show of a run."""
        from pipeline.cable.pairs import adjustment_stamp

        report = run.report or {}
        self.folder, self.finished = str(run.folder), run.report is not None
        self.blocks.clear()
        for block in run.blocks:
            item = self.blocks.add()
            item.name, item.images = block.name, len(block.frames)
            if block.orientation is not None:
                item.calibrated = int(block.orientation.calibrated.sum())
                item.reprojection_px = block.orientation.reprojection_px
                item.focal_px = block.orientation.lens.focal_px
                item.division_lambda = block.orientation.lens.division_lambda
                item.adjustment = adjustment_stamp(block.orientation)
        self._take_stations(run)
        self._take_elsewhere(report.get("stations", ()))
        self._take_truth(report.get("truth") or {})
        self.warnings = "\n".join(report.get("warnings", ()))

    def _take_stations(self, run: "OpenedRun") -> None:
        self.stations.clear()
        for section in run.measurement.sections if run.measurement else ():
            item = self.stations.add()
            item.name = section.name
            for key in FIGURES:
                setattr(item, key, getattr(section, key))
        self.station_index = min(self.station_index, max(len(self.stations) - 1, 0))

    def _take_elsewhere(self, rows: Iterable[dict]) -> None:
        """Stations of a long survey that other segments measured, from the report on the whole."""
        known = {item.name for item in self.stations}
        for row in rows:
            if row["name"] not in known:
                item = self.stations.add()
                item.name = row["name"]
                for key in FIGURES:
                    setattr(item, key, row[key])

    def _take_truth(self, truth: dict) -> None:
        self.has_truth = bool(truth.get("stations"))
        self.mean_absolute_error_mm = truth.get("mean_absolute_error_mm") or 0.0
        known = {row["name"]: row for row in truth.get("stations", ())}
        for item in self.stations:
            if item.name in known:
                item.truth_mm = known[item.name]["truth_mm"]
                item.difference_mm = known[item.name]["difference_mm"]


classes = (CableTwinBlockResult, CableTwinStationResult, CableTwinResults)
