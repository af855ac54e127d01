"""State of the area *steel*: what is run, what is shown, its tables, and how large small things are drawn."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from ..results.steel_rows import SteelRows

STEEL_STAGES = (
    ("clouds", "Point clouds", "Read the cloud of each station"),
    ("targets", "Targets", "Find the targets in each cloud"),
    ("register", "Registration", "One adjustment of all stations"),
    ("compare", "Comparison", "Station by station and by ICP"),
    ("tiles", "Tiles", "The registered points of all stations"),
    ("members", "Members", "Rods, columns and balls"),
    ("measure", "Measure", "Nodes, columns and deflection"),
    ("photos", "Photos", "A cloud from the photos"),
    ("fuse", "Fusion", "Scans and photos in one cloud"),
    ("report", "Report", "Report and files"),
)


def _follow_survey(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Propose a run folder beside the survey, where none is chosen."""
    if self.survey and not self.run_folder:
        self.run_folder = str(Path(bpy.path.abspath(self.survey)).parent / "run")


def _rescale(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.steel_show import rescale

    rescale(self.id_data)


def _show_column(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results import steel_collections
    from ..results.steel_look import choose

    if 0 <= self.column_index < len(self.columns):
        choose(context, self.id_data, steel_collections.COLUMNS, self.columns[self.column_index].name)


def _show_node(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results import steel_collections
    from ..results.steel_look import choose

    if 0 <= self.node_index < len(self.nodes):
        choose(context, self.id_data, steel_collections.BALLS, self.nodes[self.node_index].name)


class CableTwinSteelColumn(bpy.types.PropertyGroup):
    """A column's figures; its ``name`` is the column's.  What is not known is -1."""

    deviation_mm: bpy.props.FloatProperty(default=-1)
    sigma_mm: bpy.props.FloatProperty(default=-1)
    direction: bpy.props.StringProperty()
    ratio: bpy.props.FloatProperty(default=-1)
    limit_mm: bpy.props.FloatProperty(default=-1)
    over: bpy.props.BoolProperty()
    certain: bpy.props.BoolProperty()


class CableTwinSteelNode(bpy.types.PropertyGroup):
    """A node's figures; its ``name`` is the node's.  What is not known is -1."""

    size_mm: bpy.props.FloatProperty(default=-1)
    sigma_mm: bpy.props.FloatProperty(default=-1)
    significant: bpy.props.BoolProperty()


class CableTwinSteelGross(bpy.types.PropertyGroup):
    """A gross error; its ``name`` is that of its mark."""

    target: bpy.props.StringProperty()
    kind: bpy.props.StringProperty()
    stations: bpy.props.StringProperty()
    size_mm: bpy.props.FloatProperty()
    fits: bpy.props.StringProperty()


class CableTwinSteel(bpy.types.PropertyGroup):
    """A steel structure: its run and how that is looked at."""

    survey: bpy.props.StringProperty(
        name="Survey file",
        description="survey.toml of the steel structure: stations, targets, columns",
        subtype="FILE_PATH",
        update=_follow_survey,
    )
    run_folder: bpy.props.StringProperty(
        name="Run folder",
        description="Where the results go; a run that was interrupted there goes on",
        subtype="DIR_PATH",
    )
    truth: bpy.props.StringProperty(
        name="Truth",
        description="A truth.json to compare with, of a synthetic survey",
        subtype="FILE_PATH",
    )
    folder: bpy.props.StringProperty(description="The run that the scene shows", subtype="DIR_PATH")
    columns: bpy.props.CollectionProperty(type=CableTwinSteelColumn)
    column_index: bpy.props.IntProperty(
        name="Column", description="Click to select the column and look at it", update=_show_column
    )
    nodes: bpy.props.CollectionProperty(type=CableTwinSteelNode)
    node_index: bpy.props.IntProperty(
        name="Node", description="Click to select the ball and look at it", update=_show_node
    )
    gross: bpy.props.CollectionProperty(type=CableTwinSteelGross)
    stations: bpy.props.IntProperty(description="How many stations were registered")
    largest_sigma_mm: bpy.props.FloatProperty(description="Largest standard deviation of a station's place")
    sag_mm: bpy.props.FloatProperty(default=-1)
    sag_limit_mm: bpy.props.FloatProperty(default=-1)
    sag_node: bpy.props.StringProperty()
    sag_over: bpy.props.BoolProperty()
    warnings: bpy.props.StringProperty(description="One sentence a line")
    arrow_scale: bpy.props.FloatProperty(
        name="Arrow scale",
        description="How much longer than true the arrows of eccentricities and leaning columns are drawn",
        default=50,
        min=1,
        soft_max=500,
        max=10000,
        precision=0,
        step=100,
        update=_rescale,
    )
    error_scale: bpy.props.FloatProperty(
        name="Error scale",
        description="How much larger than one standard deviation the stations' error ellipsoids are drawn",
        default=500,
        min=1,
        soft_max=5000,
        max=100000,
        precision=0,
        step=1000,
        update=_rescale,
    )

    def take(self, rows: "SteelRows") -> None:
        """Keep what the panels show of a run, eccentric nodes first."""
        from ..results.steel_show import gross_name

        self.folder = str(rows.folder)
        self.stations = len(rows.stations)
        self.largest_sigma_mm = max((s.sigma_mm for s in rows.stations), default=0.0)
        self.warnings = "\n".join(rows.warnings)
        self._take_columns(rows)
        self._take_nodes(rows)
        self.gross.clear()
        for gross in rows.gross:
            item = self.gross.add()
            item.name, item.target, item.kind = gross_name(gross), gross.target, gross.kind
            item.stations, item.size_mm, item.fits = ", ".join(gross.stations), gross.size_mm, gross.fits
        for key in ("sag_mm", "sag_limit_mm", "sag_node", "sag_over"):
            self.property_unset(key)
        if rows.sag is not None:
            self.sag_mm, self.sag_limit_mm = rows.sag.largest_mm, rows.sag.limit_mm
            self.sag_node, self.sag_over = rows.sag.node, rows.sag.over

    def _take_columns(self, rows: "SteelRows") -> None:
        self.columns.clear()
        for column in rows.columns:
            item = self.columns.add()
            item.name, item.direction = column.name, column.direction
            item.over, item.certain = column.over, column.certain
            for key in ("deviation_mm", "sigma_mm", "ratio", "limit_mm"):
                _set_known(item, key, getattr(column, key))

    def _take_nodes(self, rows: "SteelRows") -> None:
        self.nodes.clear()
        known = [node for node in rows.nodes if math.isfinite(node.size_mm)]
        unknown = [node for node in rows.nodes if not math.isfinite(node.size_mm)]
        known.sort(key=lambda node: (not node.significant, -node.size_mm))
        for node in (*known, *unknown):
            item = self.nodes.add()
            item.name, item.significant = node.name, node.significant
            for key in ("size_mm", "sigma_mm"):
                _set_known(item, key, getattr(node, key))


def _set_known(item: bpy.types.PropertyGroup, key: str, value: float) -> None:
    if math.isfinite(value):
        setattr(item, key, value)


classes = (CableTwinSteelColumn, CableTwinSteelNode, CableTwinSteelGross, CableTwinSteel)
