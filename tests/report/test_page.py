"""The page is one valid, self-contained file that shows what it was given, in both languages."""

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from pipeline.report.page import PageOptions, page_html, write_report_html
from pipeline.report.viewer import ViewerOptions
from tests.report import sample

VOID = {"meta", "link", "img", "input", "br", "hr"}
SMALL = PageOptions(viewer=ViewerOptions(max_texture_px=64))
ALL_SECTIONS = [
    "diameters", "model", "unrolled", "relief", "sections", "triangulation", "lens", "lens_effect", "mosaic",
    "resources", "files",
]  # fmt: skip


class Reader(HTMLParser):
    """Collects the elements and refuses tags that do not match."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.ids, self.sections, self.resources, self.links, self.labels = [], [], [], [], [], []
        self.text = []

    def handle_starttag(self, tag, attrs):
        self._note(tag, dict(attrs))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._note(tag, dict(attrs))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if "script" not in self.open and "style" not in self.open:
            self.text.append(data)

    def _note(self, tag, attrs):
        if "id" in attrs:
            self.ids.append(attrs["id"])
        if tag == "section":
            self.sections.append(attrs["id"])
        if tag == "a":
            self.links.append(attrs["href"])
        elif "src" in attrs or ("href" in attrs and not attrs["href"].startswith("#")):
            self.resources.append(attrs.get("src") or attrs["href"])
        if "data-en" in attrs or "data-zh" in attrs:
            self.labels.append((attrs.get("data-en"), attrs.get("data-zh")))


def read(html):
    reader = Reader()
    reader.feed(html)
    reader.close()
    assert not reader.open, f"left open: {reader.open}"
    return reader


@pytest.fixture(scope="module")
def full():
    return page_html(sample.report_data(), SMALL)


def test_the_page_is_balanced_and_its_identifiers_are_unique(full):
    reader = read(full)
    assert len(reader.ids) == len(set(reader.ids))
    assert reader.sections == ALL_SECTIONS


def test_the_page_asks_no_network(full):
    reader = read(full)
    assert all(address.startswith("data:") for address in reader.resources)
    assert not re.search(r"https?://|//[a-z]+\.[a-z]+/|@import|url\((?!#)", full)
    assert [link for link in reader.links if not link.startswith("#")] == [
        "unrolled.png", "model.glb", "model.ply", "cloud.ply", "unrolled.png", "diameters.csv", "report.json",
    ]  # fmt: skip


def test_every_link_inside_the_page_leads_somewhere(full):
    reader = read(full)
    inside = {link[1:] for link in reader.links if link.startswith("#")}
    assert inside == set(ALL_SECTIONS)
    for target in re.findall(r'url\(#([^)"]+)\)|href="#([^"]+)"', full):
        assert (target[0] or target[1]) in reader.ids


@pytest.mark.parametrize(
    "shown",
    [
        "111.442", "110.769", "110.718", "111.043",  # Table 2
        "+0.042", "−0.031", "0.0370 mm", "paper: 1.0053 mm",
        "112.383", "−1.017", "1.196",  # the paper's
        "24 / 24 (100 %)", "493 / 518 (95 %)", "0.161", "−0.0200",  # Table 1
        "3\u202f231\u202f000 square units",
        "53.214", "111.063", "52 times closer",  # lens effect
        "Block1 – Block2", "312", "1.000426 (+426 ppm)", "1\u202f240",  # mosaic
        "151.1 s in all; peak memory 1834 MB.",
        "Block3: frame 17 is blurred and was left out.",
        "96 of 96", "0.032 mm", "at station D",
    ],
)  # fmt: skip
def test_the_page_shows_the_figures(full, shown):
    assert shown in " ".join(read(full).text)


def test_the_lens_effect_against_truth_is_told(full):
    # True mean 111.0: |53.214 - 111.0| = 57.79 and |111.063 - 111.0| = 0.06.
    assert "would be off by 57.79 mm on average; corrected, by 0.06 mm" in " ".join(read(full).text)


def test_every_label_stands_in_both_languages(full):
    labels = read(full).labels
    assert len(labels) > 100
    assert all(en and zh for en, zh in labels)


def test_the_page_opens_in_the_language_asked_for():
    chinese = page_html(sample.report_data(mesh=None), PageOptions(language="zh"))
    assert '<html lang="zh">' in chinese
    text = " ".join(read(chinese).text)
    assert "直径测量结果" in text
    assert "沿缆索位置 (m)" in text
    assert "Mean diameter" not in text


def test_an_unknown_language_is_refused():
    with pytest.raises(ValueError, match="'de' is none of en, zh"):
        PageOptions(language="de")


def test_without_truth_table_2_shows_the_stations_alone():
    html = page_html(sample.report_data(truth=(), mesh=None), SMALL)
    text = " ".join(read(html).text)
    assert "111.132" in text
    assert "348" in text
    assert "Truth (mm)" not in text
    assert "1.0053" not in text


def test_what_a_run_does_not_have_is_left_out():
    data = sample.report_data(
        truth=(), lens_pictures=(), lens_effects=(), unrolled=None, block_unrolled=(), profile=None,
        axis=None, mosaic=None, relief=None, mesh=None, timing_s={}, warnings=(),
    )  # fmt: skip
    html = page_html(data, PageOptions(files=()))
    assert read(html).sections == ["diameters", "sections", "triangulation"]
    assert "viewer-data" not in html


def test_figures_that_are_not_known_show_as_a_dash():
    stations = (sample.station("A", 0.1, 111.0), sample.station("B", 0.2, math.nan))
    effect = replace(sample.lens_effect(2), residual_corrected_mm=math.nan, bow_uncorrected_mm=math.nan)
    html = page_html(sample.report_data(stations=stations, lens_effects=(effect,)), SMALL)
    text = " ".join(read(html).text)
    record = re.search(r'id="viewer-data">(.*?)</script>', html).group(1)
    assert [ring["name"] for ring in json.loads(record)["stations"]] == ["A"]
    assert "nan" not in text.lower()
    assert "111.00 mm" in text  # the mean leaves B out


def test_names_from_outside_cannot_break_the_page():
    nasty = '</script><b a="'
    stations = (sample.station(nasty, 0.1, 111.0), sample.station("$x^2$", 0.2, 111.0))
    html = page_html(sample.report_data(name=nasty, stations=stations, warnings=(nasty,)), SMALL)
    reader = read(html)
    assert reader.sections[:2] == ["diameters", "model"]
    assert nasty in "".join(reader.text)


def test_a_correction_that_makes_it_worse_is_not_praised():
    worse = replace(sample.lens_effect(2), residual_uncorrected_mm=0.1, residual_corrected_mm=0.5)
    html = page_html(sample.report_data(lens_effects=(worse,), mesh=None), SMALL)
    text = " ".join(read(html).text)
    assert "fits its cylinder worse, 0.500 mm instead of 0.100 mm" in text
    assert "times closer" not in text


def test_the_page_is_written_whole(tmp_path):
    path = write_report_html(tmp_path / "report.html", sample.report_data(mesh=None))
    assert path.read_text(encoding="utf-8").endswith("</html>\n")
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]
