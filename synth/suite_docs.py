"""The suite's results as a page of the documentation: table, plots, how to read and how to repeat them.

Takes results; writes DOCS/benchmark.md and DOCS/images/benchmark-*.svg.
"""

import math
from pathlib import Path

from synth.files import write_text
from synth.suite_figures import figures
from synth.suite_plots import write_error_plot, write_sigma_plot
from synth.suite_records import Results
from synth.suite_table import extras, scenarios_markdown
from synth.suite_targets import (
    MEMORY_MB,
    OVERCLAIMED_DEG,
    SECONDS,
    SIGMA_OVER_RMS,
    TIMES_CLOSER,
    TIMES_FASTER,
    WITHIN_2_SIGMA,
    missed,
)

HEAD = """# Benchmark

Written by `python -m synth suite --docs docs`; do not edit by hand. {cases} cases, seeds {seeds}. What is
hard in each scenario stands in [synth.md](synth.md#the-benchmark) and in the first line of its specification
in `specs/bench`.

**{met} of {scenarios} scenarios meet all their targets.**{programs}

![Mean absolute error of every scenario beside its target and stock COLMAP](images/benchmark-errors.svg)

"""

READING = """
An error is measured less true diameter over the stations of all seeds; with ribs on the cable that of the
bare sheath counts. *Overclaimed* is the most coverage that any station tells where the surface is off by more
than 0.5 mm. *Time* is ours from videos to report; stock COLMAP's is that of features, matching and mapping
alone, its error that of its mean diameters. Asked of every scenario: |error| at most 2 sigma for
{within:.0f} % of the stations, sigma at most {sigma:g} times the RMS error, {closer:g} times closer
and {faster:g} times faster than stock COLMAP, at most {seconds:.0f} s, {memory:.0f} MB and {overclaimed:g}
degrees overclaimed. *Missed* names what is not met.

"""

SIGMAS = """## What sigma is worth

![Every station's error in its sigmas, by scenario and as a histogram](images/benchmark-sigma.svg)
"""

OVERALL = """
Of all {count} stations {one:.0f} % lie within one sigma and {two:.0f} % within two (68 and 95 if sigma were
exact); the root mean square of error over sigma is {rms:.2f}. Stations of one survey share that survey's
errors, so a scenario of one seed says little by itself.
"""


def write_docs(results: Results, docs: Path) -> Path:
    """Write the page and its pictures.

    Args:
        results: in the order of the page.
        docs: folder of the documentation.

    Returns:
        The page.
    """
    (docs / "images").mkdir(parents=True, exist_ok=True)
    write_error_plot(results, docs / "images" / "benchmark-errors.svg")
    write_sigma_plot(results, docs / "images" / "benchmark-sigma.svg")
    seeds = sorted({case.seed for case in results.cases})
    names = results.scenarios
    met = [
        name
        for name in names
        if not missed(name, figures(results.of(name))) and all(not c.failure for c in results.of(name))
    ]
    page = HEAD.format(
        cases=len(results.cases),
        seeds=", ".join(map(str, seeds)) or "none",
        met=len(met),
        scenarios=len(names),
        programs=_programs(results),
    )
    reading = READING.format(
        within=100 * WITHIN_2_SIGMA,
        sigma=SIGMA_OVER_RMS,
        closer=TIMES_CLOSER,
        faster=TIMES_FASTER,
        seconds=SECONDS,
        memory=MEMORY_MB,
        overclaimed=OVERCLAIMED_DEG,
    )
    write_text(
        docs / "benchmark.md",
        page + scenarios_markdown(results) + reading + _extras(results) + SIGMAS + _overall(results),
    )
    return docs / "benchmark.md"


def _extras(results: Results) -> str:
    rows = [(name, words) for name in results.scenarios if (words := extras(name, figures(results.of(name))))]
    if not rows:
        return ""
    lines = ["Beside the diameter (target in brackets):", ""]
    return "\n".join([*lines, *(f"- {name}: {words}" for name, words in rows), "", ""])


def _overall(results: Results) -> str:
    """What sigma is worth over all scenarios."""
    errors = [error for case in results.cases for error in case.errors_mm]
    in_sigmas = [difference / sigma for difference, sigma in errors if sigma]
    if not in_sigmas:
        return ""
    found = figures(results.cases)
    return OVERALL.format(
        count=len(errors),
        one=100 * (found.within_1_sigma or 0.0),
        two=100 * (found.within_2_sigma or 0.0),
        rms=math.sqrt(sum(z**2 for z in in_sigmas) / len(in_sigmas)),
    )


def _programs(results: Results) -> str:
    count = len({case.program for case in results.cases if case.program})
    return f" The cases were made by {count} versions of the program." if count > 1 else ""
