"""The plots of the report: diameter along the cable, axis, time per stage.

Takes records of ``types``, gives inline SVG (see ``svg``).  Texts come from ``labels`` in English and are
given their Chinese twin there.  Sections are in ``section_plots``, the lens comparison in ``lens_plots``.
"""

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.report.labels import TEXTS, Language, label
from pipeline.report.svg import BLUE, GREEN, INK, ORANGE, QUIET, VERMILLION, inline_svg, plot_style
from pipeline.report.types import AxisSummary, DiameterProfile, StationResult, TruthStation


def _text(key: str) -> str:
    return TEXTS[key][0]


def diameter_plot(
    stations: tuple[StationResult, ...],
    truth: tuple[TruthStation, ...],
    profile: DiameterProfile | None,
    language: Language,
) -> str:
    """Diameter in mm against position in m: profile with its sigma band, stations with error bars, truth."""
    with plot_style():
        figure = Figure(figsize=(10.4, 3.6), layout="constrained")
        axes = figure.add_subplot()
        if profile is not None:
            low, high = profile.diameter_mm - profile.sigma_mm, profile.diameter_mm + profile.sigma_mm
            axes.fill_between(
                profile.position_m, low, high, color=BLUE, alpha=0.16, linewidth=0, label=_text("plot_band")
            )
            axes.plot(profile.position_m, profile.diameter_mm, color=BLUE, label=_text("plot_measured"))
        if truth:
            axes.plot(
                [station.position_m for station in truth],
                [station.diameter_mm for station in truth],
                linestyle="none",
                marker="D",
                markersize=7,
                markerfacecolor="none",
                markeredgecolor=VERMILLION,
                markeredgewidth=1.6,
                label=_text("plot_truth"),
            )
        _draw_stations(axes, stations)
        axes.set_xlabel(_text("plot_position"))
        axes.set_ylabel(_text("plot_diameter"))
        axes.margins(x=0.02, y=0.12)
        axes.ticklabel_format(useOffset=False)
        figure.legend(loc="outside upper right", ncols=4)
        return inline_svg(figure, "diameter", label("diameters"), language)


def _draw_stations(axes: Axes, stations: tuple[StationResult, ...]) -> None:
    positions = [station.position_m for station in stations]
    diameters = [station.diameter_mm for station in stations]
    sigmas = [station.sigma_mm for station in stations]
    axes.errorbar(
        positions,
        diameters,
        yerr=sigmas,
        fmt="o",
        color=INK,
        markersize=5,
        capsize=3,
        elinewidth=1.2,
        label=_text("plot_station"),
        zorder=3,
    )
    # Names of stations that stand too close would lie on top of each other.
    if len(stations) <= 24:
        for station in stations:
            axes.axvline(station.position_m, color=QUIET, linewidth=0.8, linestyle=(0, (1, 3)), zorder=1)
            axes.annotate(
                station.name,
                (station.position_m, 1),
                xycoords=("data", "axes fraction"),
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                fontweight="bold",
            )


def axis_plot(axis: AxisSummary, language: Language) -> str:
    """Distance of the axis from its chord in mm, along x and z, against position in m; band of two sigma."""
    with plot_style():
        figure = Figure(figsize=(10.4, 2.4), layout="constrained")
        axes = figure.add_subplot()
        axes.axhline(0, color=QUIET, linewidth=0.8)
        axes.plot(axis.position_m, axis.bow_mm[:, 0], color=GREEN, label=_text("plot_along_x"))
        axes.plot(
            axis.position_m,
            axis.bow_mm[:, 1],
            color=ORANGE,
            linestyle=(0, (5, 2)),
            label=_text("plot_along_z"),
        )
        if axis.sigma_mm is not None:
            for bow, colour in zip(axis.bow_mm.T, (GREEN, ORANGE), strict=True):
                low, high = bow - 2 * axis.sigma_mm, bow + 2 * axis.sigma_mm
                axes.fill_between(axis.position_m, low, high, color=colour, alpha=0.2, linewidth=0)
        axes.set_xlabel(_text("plot_position"))
        axes.set_ylabel(_text("plot_offset"))
        axes.margins(x=0.02, y=0.15)
        figure.legend(loc="outside upper right", ncols=2)
        return inline_svg(figure, "axis", label("straightness"), language)


def time_plot(timing_s: Mapping[str, float], language: Language) -> str:
    """One bar per stage, in seconds, in the order of the stages."""
    with plot_style():
        figure = Figure(figsize=(10.4, 0.6 + 0.3 * len(timing_s)), layout="constrained")
        axes = figure.add_subplot()
        names = [TEXTS.get(f"stage_{stage}", (stage,))[0] for stage in timing_s]
        bars = axes.barh(names, list(timing_s.values()), color=BLUE, height=0.62)
        axes.bar_label(bars, fmt="%.1f", padding=4, fontsize=9.5)
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.margins(x=0.08)
        axes.set_xlabel(_text("plot_seconds"))
        return inline_svg(figure, "time", label("resources"), language)
