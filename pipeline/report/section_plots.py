"""The cross sections at the stations: fitted circle and measured surface, with the deviation enlarged.

Takes stations, gives inline SVG (see ``svg``).  The x axis points right and z up: the section as one sees it
when looking in the direction of travel.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.core.vocabulary import Array
from pipeline.report.deviation import section_deviation_mm
from pipeline.report.labels import Language, label
from pipeline.report.svg import BLUE, INK, QUIET, inline_svg, plot_style
from pipeline.report.types import StationResult

MAX_SECTIONS = 8
_SECTION_COLUMNS = 4


def shown_stations(stations: tuple[StationResult, ...]) -> tuple[StationResult, ...]:
    """The stations with a section and a circle to draw: all of them, or MAX_SECTIONS spread evenly."""
    with_points = [
        station for station in stations if len(station.section_mm) >= 8 and station.circle_radius_mm > 0
    ]
    if len(with_points) > MAX_SECTIONS:
        chosen = np.linspace(0, len(with_points) - 1, MAX_SECTIONS).round().astype(int)
        with_points = [with_points[index] for index in chosen]
    return tuple(with_points)


def exaggeration(stations: tuple[StationResult, ...]) -> int:
    """Factor of 1, 2, 5, 10, ... at which the deviations reach about a fifth of the radius."""
    deviations = np.concatenate([np.abs(section_deviation(station)[1]) for station in stations])
    radius_mm = float(np.median([station.circle_radius_mm for station in stations]))
    wanted = 0.2 * radius_mm / max(float(np.nanpercentile(deviations, 98)), 1e-6)
    steps = [step * 10**power for power in range(4) for step in (1, 2, 5)]
    return max([step for step in steps if step <= wanted], default=1)


def section_deviation(station: StationResult, step_deg: float = 1.0) -> tuple[Array, Array]:
    """Angles (k,) in degrees in the x-z plane and median distance (k,) in mm from the fitted circle there.

    One value per step; NaN where the section has no points, so that a drawn line breaks at a gap.
    """
    return section_deviation_mm(
        station.section_mm, np.asarray(station.circle_centre_mm), station.circle_radius_mm, step_deg
    )


def sections_plot(stations: tuple[StationResult, ...], factor: int, language: Language) -> str:
    """Small multiples: fitted circle and measured section, its deviation drawn ``factor`` times as large."""
    rows = -(-len(stations) // _SECTION_COLUMNS)
    with plot_style():
        figure = Figure(figsize=(10.4, 2.75 * rows), layout="constrained")
        for index, station in enumerate(stations):
            axes = figure.add_subplot(rows, _SECTION_COLUMNS, index + 1)
            _draw_section(axes, station, factor)
            _draw_scale(axes, float(np.median([each.circle_radius_mm for each in stations])), factor)
        return inline_svg(figure, "sections", label("sections"), language)


def _draw_section(axes: Axes, station: StationResult, factor: int) -> None:
    angle_deg, deviation_mm = section_deviation(station)
    # Closed: the last degree joins the first.
    angle = np.radians(np.append(angle_deg, angle_deg[0]))
    drawn_mm = station.circle_radius_mm + factor * np.append(deviation_mm, deviation_mm[0])
    around = np.linspace(0, 2 * np.pi, 181)
    radius = station.circle_radius_mm
    axes.plot(
        radius * np.cos(around), radius * np.sin(around), color=QUIET, linewidth=1, linestyle=(0, (4, 3))
    )
    axes.plot(drawn_mm * np.cos(angle), drawn_mm * np.sin(angle), color=BLUE, linewidth=1.4)
    axes.set_aspect("equal")
    axes.axis("off")
    limit = 1.42 * radius
    axes.set_xlim(-limit, limit)
    axes.set_ylim(-limit, limit)
    axes.text(0, 0.16 * radius, station.name, ha="center", va="center", fontsize=14, fontweight="bold")
    axes.text(0, -0.1 * radius, f"{station.diameter_mm:.3f} mm", ha="center", va="center", fontsize=10.5)
    _draw_azimuths(axes, radius)


def _draw_azimuths(axes: Axes, radius_mm: float) -> None:
    """Two azimuths of the cable frame, to tell how the section lies: 0 degrees is +x, 90 degrees is -z."""
    for azimuth_deg in (0, 90):
        x, z = np.cos(np.radians(azimuth_deg)), -np.sin(np.radians(azimuth_deg))
        axes.plot(
            [0.97 * radius_mm * x, 1.03 * radius_mm * x],
            [0.97 * radius_mm * z, 1.03 * radius_mm * z],
            color=QUIET,
            linewidth=1,
        )
        axes.text(
            1.34 * radius_mm * x,
            1.34 * radius_mm * z,
            f"{azimuth_deg}°",
            ha="center",
            va="center",
            fontsize=8,
            color=QUIET,
        )


def _draw_scale(axes: Axes, radius_mm: float, factor: int) -> None:
    """A bar that shows how long a round part of a millimetre of deviation is drawn."""
    steps = [step * 10.0**power for power in range(-3, 2) for step in (1, 2, 5)]
    length_mm = max(step for step in steps if step * factor <= 0.45 * radius_mm)
    half = 0.5 * length_mm * factor
    axes.plot([-half, half], [-0.42 * radius_mm] * 2, color=INK, linewidth=1.6, solid_capstyle="butt")
    axes.text(0, -0.55 * radius_mm, f"{length_mm:g} mm", ha="center", va="center", fontsize=9, color=INK)
