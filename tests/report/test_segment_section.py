"""A long survey's segments in the page: one row each, with the way to its own report."""

import re
from dataclasses import replace

from pipeline.report.markup import Writer
from pipeline.report.page import PageOptions, page_html
from pipeline.report.segment_records import SegmentSummary
from pipeline.report.segment_section import segment_section
from tests.report import sample

SEGMENT = SegmentSummary(
    name="001", from_m=0.0, to_m=0.875, start_m=0.0, length_m=1.0, frames=51,
    scale=1.001894, scale_sigma=1.3e-5, roll_deg=-2.25, link_ppm=-7.4,
    bend_mm_per_m=(1.254, -0.502), bend_sigma_mm_per_m=0.053,
)  # fmt: skip
LAST = replace(
    SEGMENT, name="002", from_m=0.875, to_m=1.5, link_ppm=float("nan"), bend_mm_per_m=(float("nan"),) * 2
)


def texts(html):
    return re.findall(r">([^<>]+)<", html)


def test_every_segment_has_its_row_and_its_report():
    html = segment_section(Writer(language="en"), (SEGMENT, LAST))
    shown = texts(html)
    for wanted in ("0.875", "51", "+1894", "13", "−2.25", "−7", "+1.25", "−0.50", "0.05", "–"):
        assert wanted in shown
    assert 'href="segments/001/report.html"' in html
    assert "2 segments" in html


def test_it_speaks_chinese():
    assert "分段" in texts(segment_section(Writer(language="zh"), (SEGMENT, LAST)))


def test_a_survey_in_one_piece_has_no_such_section():
    assert 'id="segments"' not in page_html(sample.report_data(), PageOptions())
    data = replace(sample.report_data(), segments=(SEGMENT, LAST))
    assert 'id="segments"' in page_html(data, PageOptions())
