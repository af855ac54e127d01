"""How the error grows along the chain of stations: station by station, by pairwise ICP, adjusted together.

Takes the comparison rows and, where truth is known, each station's distances from it; gives inline SVG.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from pipeline.core.vocabulary import Array
from pipeline.evaluate.steel.registration_errors import StationError
from pipeline.report.labels import Language, label
from pipeline.report.steel.plan import WIDTH_IN, text
from pipeline.report.steel.records import ComparisonRow
from pipeline.report.steel.scaling import largest
from pipeline.report.svg import BLUE, ORANGE, VERMILLION, inline_svg, plot_style

WIDE = 30
"""From this ratio of the largest to the adjusted values on, the scale is logarithmic."""
FLAT = 3
"""ICP that lost its way by more than this many times the rest would flatten all others: it is left out."""


@dataclass(frozen=True, kw_only=True)
class Ways:
    """Distances (n,) in mm of the stations from the adjusted place, or the true one; NaN where not known."""

    adjusted: Array
    chained: Array
    icp: Array

    @property
    def own(self) -> list[float]:
        """Those that set the scale."""
        return [*self.adjusted.tolist(), *self.chained.tolist()]


def chain_plot(rows: Sequence[ComparisonRow], errors: Sequence[StationError], language: Language) -> str:
    """Error against the number of set-ups.

    Without truth: the other ways against the adjustment.  With it two panels: all ways as they stand,
    relative to the base, where the predicted standard deviations belong; and each after its own best fit.
    """
    position = np.array([row.position for row in rows])
    with plot_style():
        figure = Figure(figsize=(WIDTH_IN, 3.8), layout="constrained")
        known = {row.name: row for row in errors}
        if errors:
            left, right = figure.subplots(1, 2)
            _panel(left, position, _as_they_stand(rows, known), rows, "plot_off_truth")
            _panel(right, position, _fitted(rows, known), (), "plot_off_fitted")
            handles, words = left.get_legend_handles_labels()
            figure.legend(handles, words, loc="outside upper left", ncols=5)
        else:
            _panel(figure.add_subplot(), position, _against_adjusted(rows), rows, "plot_off_place")
            figure.legend(loc="outside upper left", ncols=5)
        return inline_svg(figure, "chain", label("steel_chain"), language)


def _against_adjusted(rows: Sequence[ComparisonRow]) -> Ways:
    return Ways(
        adjusted=np.full(len(rows), np.nan),
        chained=np.array([row.chained_offset_mm for row in rows]),
        icp=np.array([row.icp_offset_mm for row in rows]),
    )


def _as_they_stand(rows: Sequence[ComparisonRow], known: Mapping[str, StationError]) -> Ways:
    return Ways(
        adjusted=_values(rows, known, "distance_mm"),
        chained=_values(rows, known, "chained_mm"),
        icp=_values(rows, known, "icp_mm"),
    )


def _fitted(rows: Sequence[ComparisonRow], known: Mapping[str, StationError]) -> Ways:
    return Ways(
        adjusted=_values(rows, known, "fitted_mm"),
        chained=_values(rows, known, "chained_fitted_mm"),
        icp=_values(rows, known, "icp_fitted_mm"),
    )


def _values(rows: Sequence[ComparisonRow], known: Mapping[str, StationError], name: str) -> Array:
    return np.array([getattr(known.get(row.station), name, math.nan) for row in rows], dtype=float)


def _panel(axes: Axes, position: Array, ways: Ways, rows: Sequence[ComparisonRow], axis_key: str) -> None:
    """One panel; with ``rows`` their predicted standard deviations as dashed lines."""
    chained_sigma = np.array([row.chained_sigma_mm for row in rows])
    adjusted_sigma = np.array([row.adjusted_sigma_mm for row in rows])
    top = 1.1 * largest([*ways.own, *chained_sigma, *adjusted_sigma])
    wide = top > WIDE * largest([*adjusted_sigma, *ways.adjusted])
    if wide or largest(ways.icp) <= FLAT * top:
        _dots(axes, position, ways.icp, ORANGE, "plot_icp", "D")
        top = max(top, 1.1 * largest(ways.icp))
    _dots(axes, position, ways.chained, VERMILLION, "plot_chained", "s")
    _dots(axes, position, ways.adjusted, BLUE, "plot_adjusted", "o")
    if rows:
        _line(axes, position, chained_sigma, VERMILLION, "plot_chained_sigma")
        _line(axes, position, adjusted_sigma, BLUE, "plot_adjusted_sigma")
    if wide:
        axes.set_yscale("log", nonpositive="mask")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    else:
        axes.set_ylim(0, top or 1.0)
    axes.set_xlabel(text("plot_setups"))
    axes.set_ylabel(text(axis_key))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.margins(x=0.02)


def _dots(axes: Axes, position: Array, values: Array, colour: str, key: str, marker: str) -> None:
    """One dot a station, and a pale line through the root mean square of each ring."""
    if not np.isfinite(values).any():
        return
    rings, rms = _rms_by_ring(position, values)
    axes.plot(rings, rms, color=colour, linewidth=1.2, alpha=0.45, zorder=2)
    axes.plot(
        position, values, marker, color=colour, markersize=4, markeredgewidth=0, label=text(key), zorder=3
    )


def _line(axes: Axes, position: Array, values: Array, colour: str, key: str) -> None:
    rings, rms = _rms_by_ring(position, values)
    axes.plot(rings, rms, color=colour, linestyle=(0, (5, 2)), linewidth=1.6, label=text(key), zorder=4)


def _rms_by_ring(position: Array, values: Array) -> tuple[Array, Array]:
    rings = np.unique(position[np.isfinite(values)])
    squares = [np.mean(values[(position == ring) & np.isfinite(values)] ** 2) for ring in rings]
    return rings, np.sqrt(squares)
