"""Figures 5 and 6 of the paper: a block without and with the lens correction, side by side, at one scale.

Takes a :class:`~pipeline.report.types.LensEffect` and the block's azimuth, gives inline SVG (see ``svg``).
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.report.labels import TEXTS, Label, Language
from pipeline.report.markup import number
from pipeline.report.svg import BLUE, INK, VALUE_GAP, VERMILLION, inline_svg, plot_style
from pipeline.report.types import LensEffect

_MAX_DOTS = 5000
# Points within this angle of the camera's azimuth make the crest line, as seen from the side.
_CREST_DEG = 6.0


@dataclass(frozen=True, kw_only=True)
class _View:
    """Surface points as the block's camera sees them: along (m), across and towards the camera (mm), (n,)."""

    along_m: Array
    across_mm: Array
    towards_mm: Array


def lens_effect_plot(effect: LensEffect, angle_deg: float, name: str, language: Language) -> str:
    """Two columns (without, with), two rows (crest line from the side, section with the circle)."""
    views = [
        _view(points, angle_deg) for points in (effect.points_uncorrected_mm, effect.points_corrected_mm)
    ]
    diameters = (effect.diameter_uncorrected_mm, effect.diameter_corrected_mm)
    bows = (effect.bow_uncorrected_mm, effect.bow_corrected_mm)
    with plot_style():
        figure = Figure(figsize=(10.4, 5.4))
        # the report's largest plots, one of each block: laying them out by itself would draw each twice
        figure.subplots_adjust(left=0.07, right=0.995, bottom=0.09, top=0.95, wspace=0.04, hspace=0.33)
        grid = figure.subplots(2, 2, sharex="row", sharey="row", height_ratios=(1, 1.45))
        _set_section_limits(grid[1, 0], views)
        for column, (view, colour) in enumerate(zip(views, (VERMILLION, BLUE), strict=True)):
            _draw_side(grid[0, column], view, colour, bows[column])
            _draw_section(grid[1, column], view, colour, diameters[column])
        for column, key in enumerate(("plot_without", "plot_with")):
            grid[0, column].set_title(TEXTS[key][0], fontsize=11, fontweight="bold", loc="left")
        grid[0, 0].set_ylabel(TEXTS["plot_crest"][0])
        grid[0, 0].update_datalim([(grid[0, 0].get_xlim()[0], -0.5), (grid[0, 0].get_xlim()[1], 0.5)])
        grid[1, 0].set_ylabel(TEXTS["plot_height"][0])
        title = Label(en=effect.block, zh=effect.block)
        return inline_svg(figure, name, title, language)


def _view(points_mm: Array, angle_deg: float) -> _View:
    """Turn points of the cable frame to the block's camera, which stands at (cos a, 0, -sin a)."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return _View(
        along_m=points_mm[:, 1] / 1000,
        across_mm=points_mm[:, 0] * sine + points_mm[:, 2] * cosine,
        towards_mm=points_mm[:, 0] * cosine - points_mm[:, 2] * sine,
    )


def _thinned(count: int) -> slice:
    return slice(None, None, max(1, count // _MAX_DOTS))


def _draw_side(axes: Axes, view: _View, colour: str, bow_mm: float) -> None:
    """The points along the crest, and their medians, as heights over the chord between the crest's ends."""
    near = _near_crest(view)
    places_m, heights_mm = _medians(view.along_m[near], view.towards_mm[near])
    if len(places_m) >= 2:
        ends = np.polyfit(places_m[[0, -1]], heights_mm[[0, -1]], 1)
        few = _thinned(int(near.sum()))
        dots_m, dots_mm = view.along_m[near][few], view.towards_mm[near][few]
        dots_mm = dots_mm - np.polyval(ends, dots_m)
        axes.plot(dots_m, dots_mm, ".", color=colour, markersize=2, alpha=0.35, rasterized=True)
        axes.plot(places_m, heights_mm - np.polyval(ends, places_m), color=INK, linewidth=1.8)
    _note(axes, "plot_bow", bow_mm)
    axes.set_xlabel(TEXTS["plot_position"][0])


def _near_crest(view: _View) -> NDArray[np.bool_]:
    """Which points (n,) lie along the line nearest to the camera."""
    return np.abs(np.degrees(np.arctan2(view.across_mm, view.towards_mm))) < _CREST_DEG


def _medians(along_m: Array, towards_mm: Array, count: int = 60) -> tuple[Array, Array]:
    """Medians of both in at most ``count`` equal steps along the cable."""
    if not len(along_m):
        return np.empty(0), np.empty(0)
    edges = np.linspace(along_m.min(), along_m.max(), count + 1)
    bins = np.clip(np.searchsorted(edges, along_m, side="right") - 1, 0, count - 1)
    filled = np.unique(bins)
    places = np.array([np.median(along_m[bins == index]) for index in filled])
    return places, np.array([np.median(towards_mm[bins == index]) for index in filled])


def _draw_section(axes: Axes, view: _View, colour: str, diameter_mm: float) -> None:
    """Points seen along the cable, and the circle of the fitted diameter under the middle of their crest."""
    few = _thinned(len(view.along_m))
    axes.plot(
        view.across_mm[few],
        view.towards_mm[few],
        ".",
        color=colour,
        markersize=1.2,
        alpha=0.25,
        rasterized=True,
    )
    crest_mm = view.towards_mm[_near_crest(view)]
    if len(crest_mm) and np.isfinite(diameter_mm):
        around = np.linspace(0, 2 * np.pi, 181)
        radius = diameter_mm / 2
        centre_mm = float(np.median(crest_mm)) - radius
        axes.plot(
            radius * np.cos(around),
            centre_mm + radius * np.sin(around),
            color=INK,
            linewidth=1.1,
            linestyle=(0, (4, 3)),
        )
    axes.set_aspect("equal")
    _note(axes, "plot_fitted", diameter_mm)
    axes.set_xlabel(TEXTS["plot_across"][0])


def _set_section_limits(axes: Axes, views: list[_View]) -> None:
    """The points of both, with a margin; of the circles only what lies there is of interest."""
    across_mm = 1.15 * max(float(np.abs(view.across_mm).max()) for view in views)
    low_mm = min(float(view.towards_mm.min()) for view in views)
    high_mm = max(float(view.towards_mm.max()) for view in views)
    margin_mm = 0.15 * (high_mm - low_mm)
    axes.set_xlim(-across_mm, across_mm)
    axes.set_ylim(low_mm - margin_mm, high_mm + margin_mm)


def _note(axes: Axes, key: str, value_mm: float) -> None:
    text = f"{TEXTS[key][0]}{VALUE_GAP}{number(value_mm, 2)} mm"
    bold = {"fontsize": 10.5, "fontweight": "bold"}
    axes.text(0.985, 0.95, text, bold, transform=axes.transAxes, ha="right", va="top")
