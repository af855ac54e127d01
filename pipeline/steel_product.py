"""From a steel survey to the finished run folder: the stages, then everything a person opens.

What :mod:`pipeline.product` is for a cable, this is for a structure.
"""

from functools import partial
from pathlib import Path

from pipeline.core.events import Emit
from pipeline.core.files import write_json
from pipeline.core.runfolder import RunFolder
from pipeline.evaluate.documents import read_document
from pipeline.report.labels import Language
from pipeline.report.steel import summary, write_steel_run
from pipeline.set_aside import drop_set_aside, none_if_refused, set_aside
from pipeline.steel.options import bind_steel_options
from pipeline.steel.run import STEEL_STAGES, run_steel
from pipeline.steel.survey_records import SteelSurvey


def make_steel_product(
    survey: SteelSurvey,
    out: Path,
    emit: Emit,
    *,
    assignments: tuple[str, ...] = (),
    start: str | None = None,
    only: str | None = None,
    truth: Path | None = None,
    language: Language = "en",
) -> str:
    """Run the steel pipeline and write the product.

    Args:
        survey: what to work on.
        out: the run folder.
        emit: progress; may raise Cancelled.
        assignments: ``STAGE.key=value`` words that override options.
        start: make this stage and all after it again.
        only: make this stage again and stop behind it.
        truth: truth.json; the report then compares with it.
        language: of the report, "en" or "zh".

    Returns:
        What to tell the person: the tables and the files to open.

    Raises:
        StageError: bad input.
    """
    with none_if_refused(out):
        options = bind_steel_options(survey, assignments)
        if truth is not None:
            read_document(truth)  # tells now, and not minutes later
        folder = RunFolder(
            out,
            _fresh(start, only),
            None if only in (None, "report") else frozenset({only or ""}),
            before_making=partial(set_aside, out),
        )
        write_json(folder.path / "options.json", options, "run")
        last = only if only and only != "report" else STEEL_STAGES[-1]
        found = run_steel(survey, options, folder, emit, last)
        if found is None or (only and only != "report"):
            return f"{only} is done in {out}"
        set_aside(out)
        report = write_steel_run(found, folder, truth, language, emit)
        drop_set_aside(out)
    return f"{summary(report)}\n\nreport  {out / 'report.html'}"


def _fresh(start: str | None, only: str | None) -> frozenset[str]:
    stages = (*STEEL_STAGES, "report")
    return frozenset(stages[stages.index(start) :] if start else (only,) if only else ())
