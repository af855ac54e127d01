"""Where the surface prior was asked for, page and report.json show the diameters without and with it."""

import json
from dataclasses import replace

from pipeline.report.exports import write_report_json
from pipeline.report.page import PageOptions, page_html
from pipeline.report.types import SurfacePriorStation, SurfacePriorSummary
from tests.report import sample

NAN = float("nan")
PRIOR = SurfacePriorSummary(
    sigma_mm=0.2,
    used=False,
    stations=(
        SurfacePriorStation(
            name="A", without_mm=111.437, with_mm=111.424, without_sigma_mm=0.019, with_sigma_mm=0.016
        ),
        SurfacePriorStation(
            name="B", without_mm=NAN, with_mm=NAN, without_sigma_mm=0.02, with_sigma_mm=0.018
        ),
    ),
)


def page(prior, language="en"):
    return page_html(sample.report_data(mesh=None, surface_prior=prior), PageOptions(language=language))


def told(tmp_path, prior):
    file = write_report_json(tmp_path / "report.json", sample.report_data(surface_prior=prior))
    return json.loads(file.read_text())["surface_prior"]


def test_the_page_shows_both_diameters_and_their_difference():
    html = page(PRIOR)
    for shown in ("111.437", "111.424", "−0.013", "0.019", "0.016", "depart by 0.20 mm"):
        assert shown in html
    assert "on the adjustment without the prior" in html


def test_the_page_says_when_the_result_stands_on_the_prior():
    html = page(replace(PRIOR, used=True))
    assert "on the adjustment with the prior, as asked for" in html
    assert "on the adjustment without the prior" not in html


def test_the_table_is_told_in_chinese():
    assert "弱表面先验" in page(PRIOR, "zh")


def test_without_a_prior_nothing_is_shown(tmp_path):
    assert "weak prior" not in page(None)
    assert told(tmp_path, None) is None


def test_report_json_tells_both_and_null_where_too_little_was_seen(tmp_path):
    tree = told(tmp_path, PRIOR)
    assert tree["sigma_mm"] == 0.2
    assert tree["used"] is False
    assert tree["stations"][0] == {
        "name": "A",
        "without_mm": 111.437,
        "with_mm": 111.424,
        "without_sigma_mm": 0.019,
        "with_sigma_mm": 0.016,
    }
    assert tree["stations"][1]["without_mm"] is None
