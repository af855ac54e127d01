"""The figure: reprojection error and diameter over a held focal length, and both found freely.

Takes results; writes one SVG or PNG.  Colours of Okabe and Ito, and a mark of its own for each series, so
that it can be read without colours.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tools.observability.adjustment import Found

STYLES: Mapping[str, Mapping[str, Any]] = {
    "one strip": {"color": "#D55E00", "marker": "s"},
    "ring of four": {"color": "#0072B2", "marker": "o"},
}


@dataclass(frozen=True, kw_only=True)
class Results:
    """Of every series in STYLES.

    Attributes:
        held: adjusted with the focal length held wrong, in ascending order.
        free: adjusted with it free, one a seed.
    """

    held: Mapping[str, Sequence[Found]]
    free: Mapping[str, Sequence[Found]]


def draw(results: Results, path: Path) -> None:
    """Write the figure; its format is that of the name."""
    with mpl.rc_context({"svg.hashsalt": "observability", "font.size": 9}):
        figure = Figure(figsize=(8.5, 6.4), layout="constrained")
        (pixels, weighed), (diameter, free) = figure.subplots(2, 2)
        _profile(pixels, results, _reprojection_px, "reprojection error, px")
        pixels.set(ylim=(0, 0.16), title="The reprojection error hardly tells")
        pixels.legend(loc="lower center", frameon=False)
        _profile(weighed, results, _sigmas_off, "square root of the cost above its least")
        weighed.set(title="All measurements together: only the ring tells")
        _profile(diameter, results, _diameter_mm, "error of the diameter, mm")
        diameter.set(title="The diameter pays")
        _free(free, results)
        free.set(title="Focal length free, from 5 % off, ten surveys")
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=150)


def _reprojection_px(found: Sequence[Found]) -> list[float]:
    return [f.reprojection_px for f in found]


def _diameter_mm(found: Sequence[Found]) -> list[float]:
    return [f.diameter_mm for f in found]


def _sigmas_off(found: Sequence[Found]) -> list[float]:
    """How many standard deviations the held value lies off the best, as the adjustment sees it."""
    least = min(f.cost for f in found)
    return [(f.cost - least) ** 0.5 for f in found]


def _profile(
    axes: Axes, results: Results, draw: Callable[[Sequence[Found]], list[float]], label: str
) -> None:
    for series, style in STYLES.items():
        found = results.held[series]
        axes.plot([f.focal_percent for f in found], draw(found), label=series, markersize=4, **style)
    _lines(axes, "error of the held focal length, %", label)


def _free(axes: Axes, results: Results) -> None:
    for series, style in STYLES.items():
        found = results.free[series]
        x, y = [f.focal_percent for f in found], _diameter_mm(found)
        axes.plot(x, y, label=series, linestyle="none", markersize=5, alpha=0.8, **style)
    _lines(axes, "error of the focal length found, %", "error of the diameter, mm")


def _lines(axes: Axes, x_label: str, y_label: str) -> None:
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(visible=True, color="0.9")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
