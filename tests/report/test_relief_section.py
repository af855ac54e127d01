"""The relief is told as a table and as one numbered map, or it is told that there is none."""

import base64
import io
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from pipeline.report import exports
from pipeline.report.markup import Writer
from pipeline.report.relief_records import ReliefSummary
from pipeline.report.relief_section import relief_plot, relief_section, relief_table
from pipeline.report.tables import diameters_table
from tests.report import sample

ENGLISH, CHINESE = Writer(language="en"), Writer(language="zh")


def texts(html):
    return re.findall(r">([^<>]+)<", html)


def map_pixels(svg):
    """The picture of the map inside the plot, rows from the top of the page: the SVG turns it over."""
    assert 'transform="scale(1 -1)' in svg
    addresses = re.findall(r'data:image/png;base64,([^"]+)"', svg)
    pictures = [Image.open(io.BytesIO(base64.b64decode(a))) for a in addresses]
    return np.asarray(max(pictures, key=lambda p: p.size[0] * p.size[1]).convert("RGBA"))[::-1].astype(int)


def test_every_feature_has_its_row_and_its_number():
    shown = texts(relief_table(ENGLISH, sample.relief().features))
    for wanted in ("ridge", "bulge", "dent", "1.97", "1.52", "0.98", "168.2", "−109.9", "0.325", "+0.600"):
        assert wanted in shown
    assert shown.count("–") == 2  # neither bulge nor dent has a pitch


def test_without_a_ridge_no_pitch_is_asked_for():
    shown = texts(relief_table(ENGLISH, sample.relief().features[1:]))
    assert "Pitch (m)" not in shown
    assert "–" not in shown


def test_the_section_speaks_chinese():
    shown = texts(relief_section(CHINESE, sample.relief()))
    for wanted in ("肋条", "凸起", "凹陷", "相对基面高度 (mm)", "方位角 (°)"):
        assert wanted in shown


def test_the_features_stand_numbered_in_the_map():
    svg = relief_plot(sample.relief(), "en")
    assert {"1", "2", "3"} <= set(texts(svg))
    assert "height over the base (mm)" in svg


def test_the_map_is_red_where_it_stands_proud_and_blue_where_it_is_dented():
    """As a camera sees it: position to the right, azimuth downwards."""
    pixels = map_pixels(relief_plot(sample.relief(), "en"))
    height, width = pixels.shape[:2]

    def at(position_m, azimuth_deg):
        column = (position_m + 0.012) / 0.484 * width
        return pixels[int((180 + azimuth_deg) / 360 * height), int(column)]

    red, blue = at(0.145, 20), at(0.325, -110)
    assert red[0] > red[2] + 60
    assert blue[2] > blue[0] + 60
    assert at(0.168, 80)[3] == 0  # not measured: nothing is drawn
    assert at(0.40, 0)[:3].min() > 220


def test_a_plain_cable_is_said_to_be_plain():
    plain = replace(sample.relief(), features=())
    shown = " ".join(texts(relief_section(ENGLISH, plain)))
    assert "Nothing stands out of the base surface by more than 0.20 mm" in shown
    assert "<table>" not in relief_section(ENGLISH, plain)


def test_a_surface_hardly_seen_is_said_to_be_unknown():
    unseen = replace(sample.relief(), features=(), height_mm=np.full((5, 5), np.nan), level_mm=math.nan)
    assert "Too little of the surface was seen" in relief_section(ENGLISH, unseen)
    assert relief_section(ENGLISH, None) == ""


def test_a_map_of_another_shape_is_refused():
    with pytest.raises(ValueError, match="height_mm has shape"):
        ReliefSummary(
            features=(), height_mm=np.zeros(3), theta_range_deg=(0, 1), y_range_m=(0, 1), level_mm=0.2
        )


def test_report_json_lists_the_features(tmp_path):
    path = exports.write_report_json(tmp_path / "report.json", sample.report_data())
    told = json.loads(path.read_text())["relief"]
    assert [f["kind"] for f in told] == ["ridge", "bulge", "dent"]
    keys = {"kind", "height_mm", "sigma_mm", "position_m", "azimuth_deg", "length_mm", "width_mm", "pitch_m"}
    assert [set(f) for f in told] == [keys] * 3
    assert [f["pitch_m"] for f in told] == [0.6, None, None]
    exports.write_report_json(path, sample.report_data(relief=None))
    assert json.loads(path.read_text())["relief"] == []


def test_the_base_diameter_is_shown_where_it_differs():
    stations = list(sample.report_data().stations)
    same = replace(stations[0], base_diameter_mm=stations[0].diameter_mm + 0.5 * stations[0].sigma_mm)
    assert "Base (mm)" not in texts(diameters_table(ENGLISH, (same,), ()))
    other = replace(stations[1], base_diameter_mm=stations[1].diameter_mm - 0.091)
    shown = texts(diameters_table(ENGLISH, (same, other), ()))
    assert "Base (mm)" in shown
    assert f"{other.base_diameter_mm:.3f}" in shown
    assert f"{same.base_diameter_mm:.3f}" not in shown
