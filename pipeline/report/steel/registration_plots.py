"""Plots of the registration: the network from above, the residuals, the error along the chain."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from pipeline.core.vocabulary import Array
from pipeline.report.labels import Language, label
from pipeline.report.steel.plan import WIDTH_IN, breadth, names, plan_figure, text
from pipeline.report.steel.records import StationRow, SteelReport
from pipeline.report.steel.residuals import coordinate_residuals
from pipeline.report.steel.scaling import largest, round_factor
from pipeline.report.svg import BLUE, ORANGE, QUIET, VERMILLION, inline_svg, plot_style

ELLIPSE_SHARE = 0.035
"""The longest half axis drawn, as part of the site's diagonal."""


def ellipse_factor(report: SteelReport) -> int:
    """How many times larger the ellipses are drawn."""
    sigmas = [float(np.sqrt(np.linalg.eigvalsh(row.covariance_mm2[:2, :2])[-1])) for row in report.stations]
    return round_factor(
        largest(sigmas), min(ELLIPSE_SHARE * breadth(_places(report)), 0.8 * _spacing(report))
    )


def _spacing(report: SteelReport) -> float:
    """Median distance of a station from its nearest neighbour in plan, m; ellipses must not run together."""
    xy = np.array([row.position_m[:2] for row in report.stations])
    apart = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    return float(np.median(apart.min(axis=1)))


def network_plot(report: SteelReport, language: Language) -> str:
    """Stations with error ellipses, targets, and from which station each one was first placed."""
    with plot_style():
        figure, axes = plan_figure(_places(report), report.north_deg)
        place = {row.name: row.position_m for row in report.stations}
        for row in report.stations:
            if row.parent in place:
                ends = np.array([place[row.parent], row.position_m])
                axes.plot(ends[:, 0], ends[:, 1], color=QUIET, linewidth=0.7, zorder=1)
        _targets(axes, report)
        factor = ellipse_factor(report)
        for number, row in enumerate(report.stations):
            axes.add_patch(_ellipse(row, factor, text("plot_ellipse") if number == 0 else ""))
        xy = np.array([row.position_m[:2] for row in report.stations])
        small = len(report.stations) > 60
        axes.plot(
            *xy.T,
            "^",
            color=BLUE,
            markersize=3.5 if small else 6.5,
            label=text("plot_scan_station"),
            zorder=4,
        )
        names(axes, [(row.name, *row.position_m[:2]) for row in report.stations])
        figure.legend(loc="outside upper left", ncols=4)
        return inline_svg(figure, "network", label("steel_registration"), language)


def _places(report: SteelReport) -> Array:
    places = [row.position_m for row in report.stations] + [row.position_m for row in report.targets]
    return np.array(places).reshape(-1, 3)


def _targets(axes: Axes, report: SteelReport) -> None:
    points = np.array([row.position_m for row in report.targets if row.kind == "point"]).reshape(-1, 3)
    if len(points):
        size = 2.2 if len(points) > 120 else 4
        axes.plot(
            points[:, 0],
            points[:, 1],
            "o",
            color=ORANGE,
            markersize=size,
            markeredgewidth=0,
            label=text("plot_target"),
            zorder=2,
        )


def _ellipse(row: StationRow, factor: int, words: str) -> Ellipse:
    """One standard deviation of the place in plan, from the eigenvectors of its covariance."""
    variances, axes = np.linalg.eigh(row.covariance_mm2[:2, :2])
    minor, major = 2 * factor * np.sqrt(np.maximum(variances, 0)) / 1000
    return Ellipse(
        row.position_m[:2],
        width=major,
        height=minor,
        angle=math.degrees(math.atan2(axes[1, 1], axes[0, 1])),
        facecolor=(0.0, 0.447, 0.698, 0.13),
        edgecolor=BLUE,
        linewidth=0.9,
        zorder=3,
        label=words,
    )


def residual_plot(report: SteelReport, language: Language) -> str:
    """Histogram of the coordinates' residuals with the normal curve of their standard deviation."""
    values = coordinate_residuals(report).ravel()
    sigma = float(np.sqrt(np.mean(values**2)))
    with plot_style():
        figure = Figure(figsize=(WIDTH_IN / 2, 3.0), layout="constrained")
        axes = figure.add_subplot()
        reach = max(3.5 * sigma, float(np.abs(values).max()), 1e-3)
        bins = int(np.clip(2 * np.sqrt(len(values)), 9, 61)) | 1
        _, edges, _ = axes.hist(values, bins=bins, range=(-reach, reach), color=BLUE, alpha=0.75, linewidth=0)
        width = float(edges[1] - edges[0])
        x = np.linspace(-reach, reach, 241)
        curve = len(values) * width * np.exp(-0.5 * (x / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))
        axes.plot(x, curve, color=VERMILLION, linewidth=1.4)
        axes.set_xlabel(text("plot_residual"))
        axes.set_ylabel(text("plot_count"))
        axes.grid(visible=False, axis="x")
        return inline_svg(figure, "residuals", label("plot_residual"), language)
