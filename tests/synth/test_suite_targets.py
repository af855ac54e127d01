"""The targets of issue 3: which figures meet them and which do not."""

from dataclasses import replace
from pathlib import Path

import pytest

from synth.suite_records import Figures
from synth.suite_targets import TARGETS, missed, target_mm

GOOD = Figures(
    mae_mm=0.02,
    mean_diameter_mm=111.0,
    within_1_sigma=1.0,
    within_2_sigma=1.0,
    sigma_over_rms=2.0,
    focal_percent=0.1,
    height_mm=0.05,
    relief_missed=0,
    bow_mm=0.1,
    overclaimed_deg=1.0,
    seconds=70.0,
    peak_memory_mb=1800.0,
    times_closer=20.0,
    times_faster=4.0,
)


def test_every_scenario_of_the_bench_has_a_target_and_no_other():
    bench = Path(__file__).parents[2] / "specs" / "bench"
    assert set(TARGETS) == {path.stem for path in bench.glob("*.toml")}


@pytest.mark.parametrize("name", TARGETS)
def test_good_figures_miss_nothing(name):
    assert missed(name, GOOD) == []


@pytest.mark.parametrize(
    ("name", "figure", "value", "word"),
    [
        ("paper", "mae_mm", 0.051, "MAE"),
        ("size_70", "mae_mm", 0.112, "MAE"),
        ("sway", "focal_percent", 0.31, "focal length"),
        ("fillet", "height_mm", 0.11, "height"),
        ("defects", "height_mm", None, "height"),
        ("defects", "relief_missed", 1, "relief missed"),
        ("curved", "bow_mm", 0.31, "bow"),
        ("scale", "within_1_sigma", 0.75, "1 sigma"),
        ("paper", "within_2_sigma", 0.89, "2 sigma"),
        ("paper", "sigma_over_rms", 3.1, "sigma / RMS"),
        ("lost_camera", "overclaimed_deg", 11.0, "coverage"),
        ("paper", "seconds", 121.0, "time"),
        ("paper", "peak_memory_mb", 4097.0, "memory"),
        ("paper", "times_closer", 4.9, "closer than stock"),
        ("paper", "times_faster", 2.9, "faster than stock"),
    ],
)
def test_one_figure_that_is_worse_misses_its_target_and_only_that(name, figure, value, word):
    assert missed(name, replace(GOOD, **{figure: value})) == [word]


def test_what_is_not_asked_of_a_scenario_is_not_missed():
    assert (
        missed("paper", replace(GOOD, focal_percent=5.0, height_mm=None, bow_mm=None, within_1_sigma=0.5))
        == []
    )
    assert missed("paper", replace(GOOD, times_closer=None, times_faster=None)) == []
    assert missed("of my own", replace(GOOD, mae_mm=9.0)) == []


def test_the_target_of_a_size_follows_the_diameter():
    assert target_mm("size_270", replace(GOOD, mean_diameter_mm=270.0)) == pytest.approx(0.27)
    assert target_mm("paper", GOOD) == 0.05
    assert target_mm("scale", GOOD) is None
