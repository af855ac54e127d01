"""The plots are inline SVG with units on their axes; section and scale arithmetic is right."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from pipeline.report.lens_plots import lens_effect_plot
from pipeline.report.plots import axis_plot, diameter_plot, time_plot
from pipeline.report.section_plots import (
    MAX_SECTIONS,
    exaggeration,
    section_deviation,
    sections_plot,
    shown_stations,
)
from tests.report import sample

DATA = sample.report_data(mesh=None)


def every_plot(language="en"):
    return {
        "diameter": diameter_plot(DATA.stations, DATA.truth, DATA.profile, language),
        "axis": axis_plot(DATA.axis, language),
        "sections": sections_plot(DATA.stations, 50, language),
        "effect0": lens_effect_plot(DATA.lens_effects[0], 180.0, "effect0", language),
        "time": time_plot(DATA.timing_s, language),
    }


@pytest.fixture(scope="module")
def plots():
    return every_plot()


def texts(svg):
    return [text.text for text in ET.fromstring(svg).iter("text")]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("diameter", ["position along the cable (m)", "diameter (mm)", "truth", "at the stations", "A", "D"]),
        ("axis", ["position along the cable (m)", "offset of the axis (mm)", "along x", "along z"]),
        ("sections", ["A", "111.442 mm", "0.2 mm"]),
        ("effect0", ["across (mm)", "towards the camera (mm)", "bow\u20026.02 mm", "diameter\u200253.21 mm"]),
        ("time", ["time (s)", "dense", "61.0"]),
    ],
)
def test_a_plot_says_what_it_shows(plots, name, words):
    assert set(words) <= set(texts(plots[name]))


def test_plots_are_responsive_and_do_not_clash(plots):
    identifiers = []
    for name, svg in plots.items():
        root = ET.fromstring(svg)
        assert root.get("viewBox")
        assert root.get("width") is None
        assert root.get("aria-label")
        found = [element.get("id") for element in root.iter() if element.get("id")]
        assert all(identifier.startswith(f"{name}-") for identifier in found)
        identifiers += found
        assert "http" not in svg
    assert len(identifiers) == len(set(identifiers))


def test_a_plot_speaks_chinese_and_keeps_english_beside(plots):
    svg = every_plot("zh")["effect0"]
    assert "弯曲\u20026.02 mm" in texts(svg)
    root = ET.fromstring(svg)
    assert {text.get("data-en") for text in root.iter("text") if text.text == "横向 (mm)"} == {"across (mm)"}


def test_plotting_leaves_the_style_of_others_alone():
    before = dict(mpl.rcParams)
    every_plot()
    assert dict(mpl.rcParams) == before


def test_plotting_twice_gives_the_same_bytes(plots):
    assert every_plot() == plots


def test_a_plot_without_profile_and_truth_shows_the_stations():
    words = texts(diameter_plot(DATA.stations, (), None, "en"))
    assert "at the stations" in words
    assert "truth" not in words


def test_the_deviation_of_an_ellipse_is_its_ovality():
    angle = np.linspace(0, 2 * np.pi, 7200, endpoint=False)
    radius = 55.5 + 0.2 * np.cos(2 * angle)
    station = sample.station("A", 0.1, 111.0)
    section = np.stack([radius * np.cos(angle) + 3, radius * np.sin(angle) - 2], axis=1)
    oval = replace(station, section_mm=section, circle_centre_mm=(3.0, -2.0))
    angle_deg, deviation_mm = section_deviation(oval)
    assert np.allclose(deviation_mm, 0.2 * np.cos(2 * np.radians(angle_deg)), atol=0.005)
    # 0.2 mm times 50 is 10 mm, just under a fifth of the radius (11.1 mm).
    assert exaggeration((oval,)) == 50


def test_a_gap_in_the_section_stays_a_gap():
    angle_deg, deviation_mm = section_deviation(sample.station("A", 0.1, 111.0))
    gap = (angle_deg > np.degrees(4.2) + 1) & (angle_deg < np.degrees(4.4) - 1)
    assert np.all(np.isnan(deviation_mm[gap]))
    assert np.isfinite(deviation_mm[~gap]).mean() > 0.98


def test_many_stations_are_thinned_evenly():
    stations = tuple(sample.station(str(index), index / 20, 111.0, count=50) for index in range(30))
    shown = shown_stations(stations)
    assert len(shown) == MAX_SECTIONS
    assert (shown[0].name, shown[-1].name) == ("0", "29")
