"""A plan: the site from above, metres, one scale both ways, with an arrow to the north.

Gives a figure whose shape follows the site, for the plots that draw on it.
"""

import math
from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import OffsetFrom
from numpy.typing import ArrayLike

from pipeline.core.vocabulary import Array
from pipeline.report.labels import TEXTS
from pipeline.report.steel.directions import north_east_axes
from pipeline.report.svg import INK, QUIET

WIDTH_IN, LEAST_IN, MOST_IN = 10.4, 3.2, 6.2
_NORTH_IN = 28.0
"""Middle of the north arrow: points from the corner of the axes, both ways."""


def text(key: str) -> str:
    """The English words of a label inside a plot; the page gives them their Chinese twin."""
    return TEXTS[key][0]


def plan_figure(places_m: ArrayLike, north_deg: float, margin_share: float = 0.06) -> tuple[Figure, Axes]:
    """A figure with axes that show all (n, 2 or 3) places, m."""
    low, high = extent(places_m)
    size = np.maximum(high - low, 0.25 * max(*(high - low), 1.0))
    middle, reach = (low + high) / 2, (0.5 + margin_share) * size
    height = min(max(WIDTH_IN * reach[1] / reach[0] + 0.9, LEAST_IN), MOST_IN)
    figure = Figure(figsize=(WIDTH_IN, height), layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="datalim")
    # as data and not as limits, which an equal scale would have to break
    axes.update_datalim([middle - reach, middle + reach])
    axes.margins(0)
    axes.set_xlabel(text("plot_x_m"))
    axes.set_ylabel(text("plot_y_m"))
    _north(axes, north_deg, _emptiest_corner(places_m, middle - reach, middle + reach))
    return figure, axes


def extent(places_m: ArrayLike) -> tuple[Array, Array]:
    """(2,) lowest and highest x and y of the known ones of (n, 2 or 3) places."""
    places = np.asarray(places_m, dtype=float).reshape(len(np.asarray(places_m)), -1)[:, :2]
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        return np.zeros(2), np.ones(2)
    return places.min(axis=0), places.max(axis=0)


def breadth(places_m: ArrayLike) -> float:
    """Diagonal of the rectangle around all places, m; 1 at least."""
    low, high = extent(places_m)
    return max(float(np.hypot(*(high - low))), 1.0)


def names_behind(axes: Axes, rows: Iterable[tuple[str, float, float]], steps: Array, most: int = 80) -> None:
    """Write names on the sides of their places that the arrows (n, 2) do not take."""
    listed = list(rows)
    if len(listed) > most:
        return
    for (name, x, y), step in zip(listed, steps, strict=True):
        away = -step / max(float(np.hypot(*step)), 1e-12)
        axes.annotate(
            name,
            (x, y),
            xytext=(16 * away[0], 10 * away[1]),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8.5,
            color=INK,
        )


def names(axes: Axes, rows: Iterable[tuple[str, float, float]], most: int = 60) -> None:
    """Write names to the upper right of their places, unless there are too many to read."""
    listed = list(rows)
    if len(listed) > most:
        return
    for name, x, y in listed:
        axes.annotate(name, (x, y), xytext=(5, 4), textcoords="offset points", fontsize=8.5, color=INK)


def _emptiest_corner(places_m: ArrayLike, low: Array, high: Array) -> tuple[int, int]:
    """The corner of the plan, (right?, upper?), that is farthest from all places."""
    places = np.asarray(places_m, dtype=float).reshape(len(np.asarray(places_m)), -1)[:, :2]
    places = places[np.isfinite(places).all(axis=1)]
    corners = [(1, 1), (0, 1), (1, 0), (0, 0)]
    if not len(places):
        return corners[0]
    ends = np.stack([low, high])
    free = [np.hypot(*(places - [ends[r, 0], ends[u, 1]]).T).min() for r, u in corners]
    return corners[int(np.argmax(free))]


def _north(axes: Axes, north_deg: float, corner_at: tuple[int, int]) -> None:
    """A short arrow in one corner, (right?, upper?)."""
    (x, y), _ = north_east_axes(north_deg)
    if not math.isfinite(x):
        return
    corner = OffsetFrom(axes.patch, corner_at, unit="points")
    middle = [-_NORTH_IN if end else _NORTH_IN for end in corner_at]
    arrow = {"arrowstyle": "-|>", "color": QUIET, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    for words, reach in (("", 14.0), (text("plot_north"), 23.0)):
        mark = axes.annotate(
            words,
            xy=(middle[0] + reach * x, middle[1] + reach * y),
            xycoords=corner,
            xytext=(middle[0] - 14 * x, middle[1] - 14 * y) if not words else None,
            textcoords=corner,
            arrowprops=None if words else arrow,
            ha="center",
            va="center",
            fontsize=9,
            fontweight="bold",
            color=QUIET,
            annotation_clip=False,
        )
        mark.set_in_layout(False)
