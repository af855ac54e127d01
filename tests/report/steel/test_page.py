"""The steel page is one valid, self-contained file that shows what it was given, in both languages."""

import json
import re
from dataclasses import replace

import pytest

from pipeline.core.files import plain
from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel import evaluate_steel
from pipeline.report.steel.collect import collect
from pipeline.report.steel.document import report_tree
from pipeline.report.steel.page import page_html
from tests.report.steel import sample
from tests.report.test_page import read

FILES = ("report.json", "stations.csv", "columns.csv", "members.glb", "cloud.ply")
ALL = [
    "registration",
    "chain",
    "model",
    "columns",
    "nodes",
    "deflection",
    "fusion",
    "paper",
    "resources",
    "files",
]


def report(**changes):
    return collect(sample.run(**changes), {"register": 1.5, "members": 40.0}, 321.0)


@pytest.fixture(scope="module")
def full():
    return page_html(report(fusion=sample.fusion()), None, FILES, "en")


@pytest.fixture(scope="module")
def text(full):
    return " ".join(read(full).text)


def test_the_page_is_balanced_and_its_identifiers_are_unique(full):
    reader = read(full)
    assert len(reader.ids) == len(set(reader.ids))
    assert reader.sections == ALL


def test_the_page_asks_no_network(full):
    reader = read(full)
    assert all(address.startswith("data:") for address in reader.resources)
    assert not re.search(r"https?://|//[a-z]+\.[a-z]+/|@import|url\((?!#)", full)
    assert [link for link in reader.links if not link.startswith("#")] == list(FILES)


def test_every_link_inside_the_page_leads_somewhere(full):
    reader = read(full)
    assert {link[1:] for link in reader.links if link.startswith("#")} == set(ALL)
    for target in re.findall(r'url\(#([^)"]+)\)|href="#([^"]+)"', full):
        assert (target[0] or target[1]) in reader.ids


def test_every_label_stands_in_both_languages(full):
    labels = read(full).labels
    assert len(labels) > 120
    assert all(en and zh for en, zh in labels)


@pytest.mark.parametrize(
    "shown",
    [
        "5 stations", "8 targets", "base station S01",
        "fit within 1.00 mm", "Rounds of re-weighting: 3", "1.07", "0.91",
        "T03 was moved: S04, S05 see it at one place, 48.0 to 50.0 mm off where others see it.",
        "What S02 calls T05 is another target: it stands 5.00 m off T05.", "It stands where T06 is.",
        "lies 8.0 mm off its adjusted place", "standard deviation is 6.8 mm, in the adjustment 0.7 mm",
        "ends 20.0 mm off",
        "7 rods, 6 balls and 2 columns",
        "2 of 3 columns lean more than 35 mm; the most, 7-P, by 39.2 mm.",
        "Within two standard deviations of the limit, on either side: 1.",
        "+32.1 ± 0.3", "+17.3 ± 0.3", "north-east", "13\u202f914", "1/382", "within, near",
        "1 of 5 nodes are eccentric", "10.0 ± 0.3",
        "9.5 ± 0.4 mm below its supports at most, at N003: 1/632 of the span of 6.00 m.",
        "The limit of 24.0 mm is kept.",
        "lies 1.44 mm (median) off the scanned surface over 82 % of its points", "0.020 %",
        "Nothing determines: a turn about the axis.", "Photos of the roof alone.",
        "leans north 32.1", "1/433", "leans west 11.9", "1/1181", "16 of 21", "under 1/250",
        "41.5 s in all; peak memory 321 MB.",
        "S05 hangs on two targets alone.",
    ],
)  # fmt: skip
def test_the_page_shows_the_figures(text, shown):
    assert shown in text


def test_nothing_unknown_shows_as_nan(text):
    assert "nan" not in text.lower()


def test_the_page_opens_in_the_language_asked_for():
    chinese = page_html(report(), None, FILES, "zh")
    words = " ".join(read(chinese).text)
    assert '<html lang="zh">' in chinese
    assert "球节点偏心" in words
    assert "距基站的设站次数" in words
    assert "Node eccentricity" not in words


def test_a_survey_of_target_lists_shows_the_registration_alone():
    html = page_html(collect(sample.targets_only(), {}, 0.0), None, (), "en")
    assert read(html).sections == ["registration", "chain", "paper"]
    assert "viewer-data" not in html


def test_without_gross_errors_and_eccentric_nodes_the_page_says_so():
    calm = report(registration=sample.registration(gross=()), nodes=sample.nodes()[1:5])
    words = " ".join(read(page_html(calm, None, (), "en")).text)
    assert "No observation contradicts the others" in words
    assert "None of 4 nodes is eccentric" in words
    assert "Arrows at the nodes" not in words


def test_one_sight_of_a_moved_target_is_told_with_its_sigma_and_what_cannot_be_known():
    alone = replace(sample.MOVED, together=("S04",), instead="S05")
    words = " ".join(
        read(page_html(report(registration=sample.registration(gross=(alone,))), None, (), "en")).text
    )
    assert "T03 seen from S04 lies 50.0 ± 1.1 mm off where the other stations see it: it was moved." in words
    assert "Only S05 sees it as well: which of the two is wrong cannot be told." in words


def test_a_limit_exceeded_is_said():
    over = replace(sample.deflection(), limit_mm=9.0, over=True)
    assert "The limit of 9.0 mm is exceeded." in " ".join(
        read(page_html(report(deflection=over), None, (), "en")).text
    )


def test_two_stations_and_one_column_are_enough_for_every_plot():
    poses = tuple(sample.pose(n) for n in range(2))
    short = sample.registration(poses=poses, parents=("", "S01"), ring=(0, 1), gross=(), residuals=())
    chained = replace(sample.chained(), poses=poses, links=sample.chained().links[:2])
    html = page_html(
        report(registration=short, chained=chained, icp=None, columns=sample.columns()[:1]), None, (), "en"
    )
    assert read(html).sections[:2] == ["registration", "chain"]


def test_names_from_outside_cannot_break_the_page():
    nasty = '</script><b a="'
    columns = (
        sample.column(nasty, (0.0, 0.0), 40.0, 1.0, 14_000.0),
        sample.column("$x^2$", (6.0, 0.0), 1.0, 1.0, 14e3),
    )
    html = page_html(
        report(survey=sample.survey(name=nasty), columns=columns, cautions=(nasty,)), None, (), "en"
    )
    reader = read(html)
    assert reader.sections[0] == "registration"
    assert nasty in "".join(reader.text)


def test_the_3d_view_holds_every_member_and_the_verdicts(full):
    record = json.loads(re.search(r'id="viewer-data">(.*?)</script>', full).group(1))
    assert (len(record["rods"]), len(record["balls"]), len(record["columns"])) == (7, 6, 3)
    assert record["rods"][0][:7] == [0.0, 0.0, 6.0, 0.0, 3.0, 6.0, 0.03]
    assert [row[7] for row in record["columns"]] == ["#d55e00", "#d55e00", "#e69f00"]
    assert [entry["name"] for entry in record["names"]] == ["8-N", "7-P", "6-Q", "N001"]
    assert len(record["arrows"]) == 4
    assert len(record["stations"]) == 5


def true_of(report):
    """The truth that the sample's report would have, its stations 1 mm higher."""
    return {
        "format": 1,
        "kind": "steel",
        "stations": [
            {
                "name": row.name,
                "rotation": row.rotation.tolist(),
                "translation": [*row.position_m[:2], row.position_m[2] + 0.001 * (n > 0)],
            }
            for n, row in enumerate(report.stations)
        ],
        "targets": [{"name": row.name, "position_m": row.position_m} for row in report.targets],
        "rods": [
            {"name": row.name, "start_m": row.start_m, "end_m": row.end_m, "radius_mm": row.radius_mm}
            for row in report.rods
        ],
        "nodes": [
            {
                "name": row.name,
                "ball_m": row.ball_m,
                "rods_m": row.rods_m,
                "radius_mm": 100.0,
                "eccentricity_mm": [6.0, 8.0, 0.0],
            }
            for row in report.nodes
        ],
        "columns": [
            {
                "name": row.name,
                "bottom_m": row.bottom_m,
                "tilt_mm": [row.east_mm, row.north_mm],
                "over_limit": row.over_limit,
            }
            for row in report.columns
        ],
        "gross": [],
    }


def test_with_truth_the_page_compares_and_names_the_targets():
    told = report()
    run = Document(file="report.json", where="", values=plain(report_tree(told)))
    truth = Document(file="truth.json", where="", values=plain(true_of(told)))
    html = page_html(told, evaluate_steel(run, truth), (), "en")
    words = " ".join(read(html).text)
    assert "truth" in read(html).sections
    assert re.search(r"Station positions, RMS \(mm\)\s+1\.00\s+≤ 1", words)
    assert re.search(r"Column deviation, largest error \(mm\)\s+0\.00\s+≤ 1", words)
    assert re.search(r"Columns judged right\s+3 / 3", words)
    assert re.search(r"Nodes false, missed\s+0, 4", words)  # of the five judged the run calls one eccentric
    assert re.search(r"Gross errors named, missed, false\s+0, 0, 3", words)
    assert "after the best fit (mm)" in words


def test_a_chain_of_the_base_alone_is_no_comparison():
    """Where stations hang on names alone, none but the base can be placed one by one."""
    whole = sample.chained()
    base = replace(whole, poses=whole.poses[:1], links=whole.links[:1])
    assert "chain" not in read(page_html(report(chained=base, icp=None), None, FILES, "en")).sections
