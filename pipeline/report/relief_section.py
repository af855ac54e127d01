"""The section on the relief: a table of what stands out, and the unrolled map of heights with its numbers.

Takes a :class:`~pipeline.report.relief_records.ReliefSummary`, gives HTML.
"""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.core.vocabulary import Array
from pipeline.report.labels import TEXTS, Label, Language, label
from pipeline.report.markup import Row, Writer, number, signed
from pipeline.report.relief_records import ReliefFeature, ReliefSummary
from pipeline.report.svg import INK, inline_svg, plot_style

_MOST_CELLS = 400  # of the map in the page, either way
_COLUMNS = ("relief_kind", "relief_height_mm", "sigma_mm", "position_m", "relief_azimuth_deg")
_SIZES = ("relief_length_mm", "relief_width_mm", "relief_pitch_m")


def relief_section(writer: Writer, relief: ReliefSummary | None) -> str:
    """The whole section, or "" where the run has no relief."""
    if relief is None:
        return ""
    if not np.isfinite(relief.height_mm).any():
        return writer.say("relief_unknown", "p")
    if relief.features:
        html = relief_table(writer, relief.features)
    else:
        html = writer.say("relief_none", "p", level=number(relief.level_mm, 2))
    return html + writer.figure(
        relief_plot(relief, writer.language), writer.say("relief_map_caption", "figcaption")
    )


def relief_table(writer: Writer, features: tuple[ReliefFeature, ...]) -> str:
    """One row a feature, numbered as in the picture."""
    pitched = any(math.isfinite(f.pitch_m) for f in features)
    columns = (*_COLUMNS, *(_SIZES if pitched else _SIZES[:-1]))
    heads = [writer.say(key, "th", 'scope="col"') for key in ("relief_number", *columns)]
    rows = []
    for index, feature in enumerate(features):
        cells: list[str | Label] = [
            label(f"relief_{feature.kind}"),
            number(feature.height_mm, 2),
            number(feature.sigma_mm, 2),
            number(feature.position_m, 3),
            number(feature.azimuth_deg, 1),
            number(feature.length_mm, 0),
            number(feature.width_mm, 1),
        ]
        if pitched:
            cells.append(signed(feature.pitch_m, 3))
        rows.append(Row(head=f'<th scope="row">{index + 1}</th>', cells=cells))
    note = writer.say("relief_note", "p", 'class="note"')
    return writer.table(writer.say("relief_caption", "figcaption"), heads, rows, note)


def relief_plot(relief: ReliefSummary, language: Language) -> str:
    """The map in colours of one scale, as a camera sees it: position to the right, azimuth downwards."""
    with plot_style():
        figure = Figure(figsize=(10.4, 5.2), layout="constrained")
        axes = figure.add_subplot()
        heights = _thinned(relief.height_mm)
        limit = max([1.25 * relief.level_mm, *(f.height_mm for f in relief.features)])
        picture = axes.imshow(
            heights.T,
            cmap="RdBu_r",
            vmin=-limit,
            vmax=limit,
            origin="upper",
            extent=(*relief.y_range_m, *relief.theta_range_deg[::-1]),
            aspect="auto",
            interpolation="nearest",
        )
        axes.grid(visible=False)
        bar = figure.colorbar(picture, ax=axes, pad=0.015)
        bar.set_label(TEXTS["plot_relief"][0])
        bar.outline.set_visible(False)
        axes.set_xlabel(TEXTS["plot_position"][0])
        axes.set_ylabel(TEXTS["plot_azimuth"][0])
        axes.set_yticks([t for t in range(-360, 361, 60) if _inside(t, relief.theta_range_deg)])
        for index, feature in enumerate(relief.features):
            _mark(axes, relief, feature, str(index + 1))
        return inline_svg(figure, "relief", label("relief"), language)


def _inside(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] - 1e-6 <= value <= limits[1] + 1e-6


def _mark(axes: Axes, relief: ReliefSummary, feature: ReliefFeature, text: str) -> None:
    """The number beside the feature's middle."""
    left = relief.theta_range_deg[0]
    azimuth_deg = left + (feature.azimuth_deg - left) % 360
    axes.annotate(
        text,
        (feature.position_m, azimuth_deg),
        xytext=(14, 12),
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=10,
        fontweight="bold",
        color=INK,
        bbox={"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.8},
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.8},
    )


def _thinned(heights: Array) -> Array:
    """Means of squares of cells, so many that the map stays small in the page; NaN where none is measured."""
    rows, columns = (max(-(-side // _MOST_CELLS), 1) for side in heights.shape)
    n, m = heights.shape[0] // rows, heights.shape[1] // columns
    cells = heights[: n * rows, : m * columns].reshape(n, rows, m, columns)
    known = np.isfinite(cells)
    count = known.sum(axis=(1, 3))
    total = np.where(known, cells, 0.0).sum(axis=(1, 3))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
