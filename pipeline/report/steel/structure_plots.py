"""Plots of what is judged: columns and nodes from above with arrows, eccentricities in order, deflection."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import TriAnalyzer, Triangulation, UniformTriRefiner

from pipeline.core.vocabulary import Array
from pipeline.report.labels import Language, label
from pipeline.report.steel import colours
from pipeline.report.steel.plan import WIDTH_IN, breadth, names_behind, plan_figure, text
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.scaling import largest, round_factor
from pipeline.report.steel.structure_rows import ColumnRow, DeflectionSummary, NodeRow
from pipeline.report.svg import BLUE, INK, QUIET, VERMILLION, inline_svg, plot_style

COLUMN_SHARE, NODE_SHARE = 0.09, 0.06
"""The longest arrow drawn, as part of the site's diagonal."""
MOST_SIZES = 120


def column_plan_factor(columns: Sequence[ColumnRow]) -> int:
    """How many times larger the columns' deviations are drawn in plan."""
    return round_factor(
        largest(row.deviation_mm for row in columns),
        COLUMN_SHARE * breadth([row.bottom_m for row in columns]),
    )


def columns_plot(report: SteelReport, language: Language) -> str:
    """Each column with an arrow towards where its top lies, in the colour of its verdict."""
    columns = report.columns
    factor = column_plan_factor(columns)
    feet = np.array([row.bottom_m[:2] for row in columns])
    steps = np.array([np.subtract(row.top_m[:2], row.bottom_m[:2]) for row in columns])
    with plot_style():
        figure, axes = plan_figure(
            np.concatenate([feet, feet + factor * steps]), report.north_deg, margin_share=0.08
        )
        painted = [colours.of_column(row) for row in columns]
        _arrows(axes, feet, factor * steps, painted)
        axes.scatter(feet[:, 0], feet[:, 1], s=26, c=painted, zorder=4, linewidths=0)
        names_behind(axes, [(row.name, *row.bottom_m[:2]) for row in columns], steps)
        kinds = [("plot_within", colours.GOOD), ("plot_near", colours.UNSURE), ("plot_over", colours.BAD)]
        figure.legend(handles=_handles(kinds, set(painted)), loc="outside upper left", ncols=3)
        return inline_svg(figure, "columns-plan", label("steel_columns"), language)


def node_plan_factor(nodes: Sequence[NodeRow]) -> int:
    """How many times larger eccentricities are drawn in plan."""
    return round_factor(
        largest(row.size_mm for row in nodes if row.significant),
        NODE_SHARE * breadth([row.ball_m for row in nodes]),
    )


def nodes_plot(report: SteelReport, language: Language) -> str:
    """Each judged node; the eccentric ones with an arrow from the rods' meeting point towards the ball."""
    nodes = judged(report.nodes)
    loud = [row for row in nodes if row.significant]
    factor = node_plan_factor(nodes)
    with plot_style():
        figure, axes = plan_figure([row.ball_m for row in nodes], report.north_deg)
        quiet = np.array([row.ball_m[:2] for row in nodes if not row.significant]).reshape(-1, 2)
        axes.plot(
            *quiet.T,
            "o",
            markerfacecolor="none",
            markeredgecolor=colours.GOOD,
            markersize=4.5 if len(nodes) < 300 else 2.5,
            markeredgewidth=1,
        )
        if loud:
            start = np.array([row.ball_m[:2] for row in loud])
            step = np.array([row.eccentricity_mm[:2] for row in loud]) / 1000
            _arrows(axes, start, factor * step, [colours.BAD] * len(loud))
            axes.plot(*start.T, "o", color=colours.BAD, markersize=4, markeredgewidth=0)
            names_behind(axes, [(row.name, *row.ball_m[:2]) for row in loud], step)
        kinds = [("plot_not_significant", colours.GOOD), ("plot_eccentric", colours.BAD)]
        figure.legend(handles=_handles(kinds, {colours.GOOD, colours.BAD}), loc="outside upper left", ncols=2)
        return inline_svg(figure, "nodes-plan", label("steel_nodes"), language)


def judged(nodes: Sequence[NodeRow]) -> list[NodeRow]:
    """The nodes whose eccentricity is known, the largest first."""
    return sorted((row for row in nodes if np.isfinite(row.size_mm)), key=lambda row: -row.size_mm)


def sizes_plot(report: SteelReport, language: Language) -> str:
    """Eccentricities in order with their standard deviations as bars."""
    nodes = judged(report.nodes)[:MOST_SIZES]
    with plot_style():
        figure = Figure(figsize=(WIDTH_IN, 2.8), layout="constrained")
        axes = figure.add_subplot()
        for wanted, colour, key in (
            (True, colours.BAD, "plot_eccentric"),
            (False, colours.GOOD, "plot_not_significant"),
        ):
            chosen = [(n, row) for n, row in enumerate(nodes, 1) if row.significant == wanted]
            if chosen:
                axes.errorbar(
                    [n for n, _ in chosen],
                    [row.size_mm for _, row in chosen],
                    yerr=[row.sigma_mm for _, row in chosen],
                    fmt="o",
                    color=colour,
                    markersize=4,
                    elinewidth=1,
                    label=text(key),
                )
        axes.set_xlim(0, len(nodes) + 1)
        axes.set_ylim(bottom=0)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel(text("plot_nodes"))
        axes.set_ylabel(text("plot_eccentricity"))
        figure.legend(loc="outside upper left", ncols=2)
        return inline_svg(figure, "nodes-sizes", label("plot_eccentricity"), language)


def deflection_plot(report: SteelReport, deflection: DeflectionSummary, language: Language) -> str:
    """The nodes from above, coloured by their deflection; contours where enough of them spread out."""
    places = np.array([row.position_m for row in deflection.rows])
    values = np.array([row.deflection_mm for row in deflection.rows])
    with plot_style():
        figure, axes = plan_figure(places, report.north_deg)
        if _spread_out(places):
            _contours(axes, places, values)
        points = axes.scatter(
            places[:, 0], places[:, 1], c=values, cmap="viridis_r", s=34, linewidths=0, zorder=3
        )
        bar = figure.colorbar(points, ax=axes, shrink=0.85, pad=0.02, label=text("plot_deflection"))
        bar.outline.set_visible(False)
        _supports(axes, deflection)
        return inline_svg(figure, "deflection-plan", label("steel_deflection"), language)


def _contours(axes: Axes, places: Array, values: Array) -> None:
    """Smooth lines of equal deflection, from a twentieth of the largest on: at the supports all is noise."""
    grid = Triangulation(places[:, 0], places[:, 1])
    grid.set_mask(TriAnalyzer(grid).get_flat_tri_mask(0.02))
    fine, smooth = UniformTriRefiner(grid).refine_field(values, subdiv=3)
    steps = np.asarray(MaxNLocator(7).tick_values(float(values.min()), float(values.max())), dtype=float)
    levels = steps[(steps > 0.05 * float(np.abs(values).max())) & (steps <= values.max())]
    if not len(levels):
        return
    lines = axes.tricontour(fine, smooth, levels=levels, colors=QUIET, linewidths=0.8, zorder=1)
    axes.clabel(lines, fmt="%g", fontsize=8, colors=INK)


def profile_plot(deflection: DeflectionSummary, language: Language) -> str:
    """Deflection along the structure's long side, with the limit."""
    places = np.array([row.position_m[:2] for row in deflection.rows])
    along = _along(places)
    values = [row.deflection_mm for row in deflection.rows]
    with plot_style():
        figure = Figure(figsize=(WIDTH_IN, 3.0), layout="constrained")
        axes = figure.add_subplot()
        axes.axhline(
            deflection.limit_mm,
            color=VERMILLION,
            linestyle=(0, (5, 2)),
            linewidth=1.4,
            label=text("plot_limit"),
        )
        sigmas = [row.sigma_mm for row in deflection.rows]
        axes.errorbar(along, values, yerr=sigmas, fmt="o", color=BLUE, markersize=3.6, elinewidth=1)
        axes.invert_yaxis()
        axes.set_xlabel(text("plot_along"))
        axes.set_ylabel(text("plot_deflection"))
        figure.legend(loc="outside upper left", ncols=2)
        return inline_svg(figure, "deflection-profile", label("plot_deflection"), language)


def _along(places: Array) -> Array:
    """(n,) metres along the direction in which the places (n, 2) spread most, from the first."""
    local = places - places.mean(axis=0)
    axis = np.linalg.svd(local, full_matrices=False)[2][0]
    along = local @ axis
    return along - along.min()


def _spread_out(places: Array) -> bool:
    """Whether triangles between the places make sense: six or more that do not lie along one line."""
    if len(places) < 6:
        return False
    spread = np.linalg.svd(places[:, :2] - places[:, :2].mean(axis=0), compute_uv=False)
    return bool(spread[1] > 0.08 * spread[0])


def _supports(axes: Axes, deflection: DeflectionSummary) -> None:
    held = np.array([row.position_m[:2] for row in deflection.rows if row.support]).reshape(-1, 2)
    axes.plot(
        held[:, 0], held[:, 1], "s", markerfacecolor="none", markeredgecolor=INK, markersize=8, zorder=4
    )


def _arrows(axes: Axes, starts: Array, steps: Array, painted: list[str]) -> None:
    """Arrows in the plan's own units."""
    axes.quiver(
        *starts.T,
        *steps.T,
        color=painted,
        angles="xy",
        scale_units="xy",
        scale=1,
        width=0.0028,
        headwidth=4.2,
        headlength=5.2,
        zorder=3,
    )


def _handles(kinds: list[tuple[str, str]], used: set[str]) -> list[Line2D]:
    return [
        Line2D([], [], linestyle="none", marker="o", color=colour, markersize=6, label=text(key))
        for key, colour in kinds
        if colour in used
    ]
