"""From a survey to the finished run folder: the stages, then everything a person opens.

This is the one call that the command line, the Blender extension and the benchmarks make.
"""

from functools import partial
from importlib import import_module
from pathlib import Path
from threading import Thread

from pipeline.cable.pairs import read_pairs
from pipeline.cable.run import STAGES, bind_options, run_cable
from pipeline.cable.survey import Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import write_json
from pipeline.core.runfolder import RunFolder
from pipeline.evaluate.documents import read_document
from pipeline.report.labels import Language
from pipeline.report.metrics import compare_with_truth, mean_absolute_error_mm
from pipeline.report.types import ReportData, TruthStation
from pipeline.report.written import write_run
from pipeline.set_aside import drop_set_aside, none_if_refused, set_aside


def make_product(
    survey: Survey,
    out: Path,
    emit: Emit,
    *,
    assignments: tuple[str, ...] = (),
    start: str | None = None,
    only: str | None = None,
    pairs: Path | None = None,
    truth: Path | None = None,
    language: Language = "en",
) -> str:
    """Run the pipeline and write the product.

    Once anything is made again, or the run is refused, what an earlier run left to be opened lies in
    ``OUT/outdated`` (:mod:`pipeline.set_aside`), until the new files are there.

    Args:
        survey: what to work on.
        out: the run folder.
        emit: progress; may raise Cancelled.
        assignments: ``STAGE.key=value`` words that override options.
        start: make this stage and all after it again.
        only: make this stage again and stop behind it.
        pairs: corresponding points chosen by hand.
        truth: truth.json; the report then compares with it.
        language: of the report, "en" or "zh".

    Returns:
        What to tell the person: the table of diameters and the files to open.

    Raises:
        StageError: bad input.
    """
    with none_if_refused(out):
        options = bind_options(survey, assignments)
        true = _truth_stations(truth, survey)
        if pairs:
            read_pairs(pairs, tuple(b.name for b in survey.blocks))  # tells now, and not minutes later
        folder = _folder(out, start, only)
        write_json(folder.path / "options.json", options, "run")
        last = only if only and only != "report" else STAGES[-1]
        if last == STAGES[-1]:
            # Matplotlib takes its time to load: while frames are read, so that the report need not wait
            Thread(target=import_module, args=("pipeline.report.page",), daemon=True).start()
        found = run_cable(survey, options, folder, emit, pairs, last)
        if found is None or (only and only != "report"):
            return f"{only} is done in {out}"
        set_aside(out)
        data = write_run(found, folder, true, language, emit)
        drop_set_aside(out)
        emit(Event(stage="report", done=1, total=1))
    return _summary(data, out)


def _folder(out: Path, start: str | None, only: str | None) -> RunFolder:
    stages = (*STAGES, "report")
    fresh = frozenset(stages[stages.index(start) :] if start else (only,) if only else ())
    allowed = None if only in (None, "report") else frozenset({only or ""})
    return RunFolder(out, fresh, allowed, before_making=partial(set_aside, out))


def _truth_stations(path: Path | None, survey: Survey) -> tuple[TruthStation, ...]:
    if path is None:
        return ()
    known = tuple(
        TruthStation(
            name=s.text("name"), position_m=s.number("position_m"), diameter_mm=s.number("diameter_mm")
        )
        for s in read_document(path).items("stations")
    )
    names = [s.name for s in survey.cable.stations]
    if not any(s.name in names for s in known):
        raise StageError(
            "run",
            f"{path} knows none of the survey's stations {', '.join(names[:5])}",
            "give the truth of this survey",
        )
    return known


def _summary(data: ReportData, out: Path) -> str:
    compared = compare_with_truth(data.stations, data.truth)
    lines = [
        "station  position m  diameter mm  sigma mm" + ("   truth mm  difference mm" if compared else "")
    ]
    for s in data.stations:
        line = f"{s.name:8s} {s.position_m:10.3f} {s.diameter_mm:12.3f} {s.sigma_mm:9.3f}"
        if s.name in compared:
            row = compared[s.name]
            line += f" {row.truth_mm:10.3f} {row.difference_mm:+14.3f}"
        lines.append(line)
    if compared:
        mae = mean_absolute_error_mm(compared)
        lines.append(f"mean absolute error {mae:.3f} mm (paper: 1.0053 mm)")
    lines.append("")
    lines.extend(
        f"{what:7s} {out / name}" for what, name in (("model", "model.glb"), ("report", "report.html"))
    )
    return "\n".join(lines)
