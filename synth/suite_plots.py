"""The suite's two pictures: errors beside targets and stock COLMAP, and errors in their sigmas.

Takes results; writes SVG files.  Colours are those of Okabe and Ito, which people with any colour vision can
tell apart; shapes differ as well.
"""

import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from synth.suite_figures import figures
from synth.suite_records import Results
from synth.suite_targets import target_mm

BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#555555"
PAPER_MAE_MM = 1.0053
LEAST_MM = 1e-3
"""Errors below are drawn here: on a log axis nothing is at zero."""

MOST_SIGMAS = 4.0
HALF_NORMAL = math.sqrt(2.0 / math.pi)


def write_error_plot(results: Results, path: Path) -> None:
    """Mean absolute error of every scenario on a log axis, seeds apart, beside target and stock COLMAP."""
    names = [name for name in results.scenarios if figures(results.of(name)).mae_mm is not None]
    figure, axes = _figure(8.0, 1.6 + 0.36 * max(len(names), 1))
    for row, name in enumerate(names):
        cases = results.of(name)
        found, target = figures(cases), target_mm(name, figures(cases))
        seeds = [value for case in cases if (value := figures([case]).mae_mm) is not None]
        axes.plot([max(s, LEAST_MM) for s in seeds], [row] * len(seeds), "o", mfc="none", mec=BLUE, ms=5)
        axes.plot(max(found.mae_mm or 0.0, LEAST_MM), row, "o", color=BLUE, ms=8)
        if target is not None:
            axes.plot([target, target], [row - 0.36, row + 0.36], "-", color="black", lw=2.2)
        if found.stock_mae_mm is not None:
            axes.plot(found.stock_mae_mm, row, "D", color=ORANGE, ms=7)
    axes.axvline(PAPER_MAE_MM, color=GREY, ls=":", lw=1.2)
    for style, colour, word in (
        ("o", BLUE, "CableTwin, all seeds"),
        ("D", ORANGE, "stock COLMAP"),
    ):
        axes.plot([], [], style, color=colour, label=word)
    axes.plot([], [], "o", mfc="none", mec=BLUE, ms=5, label="one seed")
    axes.plot([], [], "|", color="black", ms=12, mew=2.2, label="target")
    axes.plot([], [], ":", color=GREY, label="the paper's MAE")
    axes.set_xscale("log")
    axes.set_xlabel("mean absolute error of the diameter, mm")
    _name_rows(axes, names)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False, fontsize=8
    )
    _save(figure, path)


def write_sigma_plot(results: Results, path: Path) -> None:
    """Every station's error in its sigmas, by scenario and as a histogram beside what a normal error would
    give."""
    z = {name: _sigmas(results, name) for name in results.scenarios}
    names = [name for name, values in z.items() if len(values)]
    figure = Figure(figsize=(8.0, 1.4 + 0.36 * max(len(names), 4)), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    for row, name in enumerate(names):
        places = row + np.linspace(-0.22, 0.22, len(z[name]))  # side by side, so that none hides another
        far = z[name] > MOST_SIGMAS
        left.plot(z[name][~far], places[~far], "o", color=BLUE, ms=3.5, alpha=0.7, mew=0)
        left.plot(np.full(far.sum(), MOST_SIGMAS), places[far], ">", color=ORANGE, ms=6)
    for sigmas, style in ((1.0, ":"), (2.0, "--")):
        left.axvline(sigmas, color=GREY, ls=style, lw=1.2)
    left.set_xlim(0.0, MOST_SIGMAS * 1.03)
    left.set_xlabel("|error| / sigma  (arrow: beyond)")
    _name_rows(left, names)
    everything = np.concatenate([z[name] for name in names]) if names else np.zeros(0)
    edges = np.linspace(0.0, MOST_SIGMAS, 17)
    weights = np.full(len(everything), 1.0 / max(len(everything), 1) / (edges[1] - edges[0]))
    right.hist(np.minimum(everything, MOST_SIGMAS - 1e-9), edges, weights=weights, color=BLUE, alpha=0.75)
    at = np.linspace(0.0, MOST_SIGMAS, 200)
    right.plot(at, HALF_NORMAL * np.exp(-(at**2) / 2.0), color="black", lw=1.6, label="if sigma were exact")
    right.set_xlabel("|error| / sigma, all stations")
    right.margins(y=0.18)
    right.set_yticks([])
    right.legend(frameon=False, fontsize=8)
    for side in ("top", "right", "left"):
        right.spines[side].set_visible(False)
    _save(figure, path)


def _sigmas(results: Results, name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Sizes of a scenario's errors in their sigmas."""
    errors = [error for case in results.of(name) for error in case.errors_mm]
    return np.array([abs(difference) / sigma for difference, sigma in errors if sigma], dtype=np.float64)


def _figure(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def _name_rows(axes: Axes, names: list[str]) -> None:
    axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.grid(axis="x", which="major", color="#dddddd", lw=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def _save(figure: Figure, path: Path) -> None:
    """Write an SVG that is the same for the same figures, under a temporary name first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.stem}.part{path.suffix}")
    with mpl.rc_context({"svg.hashsalt": "cabletwin"}):
        figure.savefig(temporary, metadata={"Date": None}, facecolor="white")
    temporary.replace(path)
