"""The page of the benchmark and its pictures."""

import xml.etree.ElementTree as ET
from dataclasses import replace

from synth.suite_docs import write_docs
from synth.suite_records import Case, Results, StationFigures

STATIONS = tuple(
    StationFigures(
        name=name,
        truth_mm=111.0,
        difference_mm=d,
        sigma_mm=0.02,
        base_difference_mm=d / 2,
        base_sigma_mm=0.02,
    )
    for name, d in (("A", 0.01), ("B", -0.03), ("C", 0.02))
)
PAPER = Case(
    scenario="paper",
    seed=1,
    stations=STATIONS,
    overclaimed_deg=0.0,
    seconds=60.0,
    peak_memory_mb=1500.0,
    program="abc",
    stock={"mae_mm": 0.6, "seconds": 300.0, "failure": None},
)
RIBBED = replace(
    PAPER, scenario="fillet", counts_base=True, height_mm=0.3, relief_missed=0, relief_false=1, program="def"
)


def test_the_page_says_what_is_met_and_what_is_missed(tmp_path):
    page = write_docs(Results(cases=(PAPER, replace(PAPER, seed=2), RIBBED)), tmp_path).read_text()
    assert "3 cases, seeds 1, 2." in page
    assert (
        "**1 of 2 scenarios meet all their targets.** The cases were made by 2 versions of the program."
        in page
    )
    assert "| paper | 1, 2 | 0.020 | 0.05 | 0.030 | 100 % | 0.9 |" in page
    assert "| 0.600 | 30.0 | 300 | 5.0 |  |" in page
    assert "| 0.600 | 60.0 | 300 | 5.0 | height |" in page
    assert "- fillet: height 0.300 mm (0.1), 0 missed, 1 false" in page


def test_the_page_tells_what_sigma_is_worth_over_all_stations(tmp_path):
    """Of two stations, one 1.5 sigma off, the other 2.5."""
    stations = tuple(replace(PAPER.stations[0], difference_mm=d, sigma_mm=0.02) for d in (0.03, -0.05))
    page = write_docs(Results(cases=(replace(PAPER, stations=stations),)), tmp_path).read_text()
    assert "Of all 2 stations 0 % lie within one sigma and 50 % within two" in page
    assert "error over sigma is 2.06" in page


def test_its_pictures_are_there_and_the_same_every_time(tmp_path):
    results = Results(cases=(PAPER, RIBBED))
    for folder in ("a", "b"):
        write_docs(results, tmp_path / folder)
    for name in ("benchmark-errors.svg", "benchmark-sigma.svg"):
        first, second = ((tmp_path / folder / "images" / name).read_bytes() for folder in ("a", "b"))
        assert first == second
        assert ET.fromstring(first).tag.endswith("svg")


def test_failed_cases_and_none_at_all_make_a_page_too(tmp_path):
    failed = Case(scenario="paper", seed=1, failure="match: nothing; light it.")
    page = write_docs(Results(cases=(failed,)), tmp_path).read_text()
    assert "**0 of 1 scenarios meet all" in page
    assert "- paper, seed 1: match: nothing; light it." in page
    assert "0 cases, seeds none." in write_docs(Results(), tmp_path).read_text()
