"""From a survey to the finished run folder: the stages, then everything a person opens.

This is the one call that the command line, the Blender extension and the benchmarks make.
"""

from functools import partial
from importlib import import_module
from pathlib import Path
from threading import Thread

from pipeline.cable.chain import Chain
from pipeline.cable.pairs import read_pairs
from pipeline.cable.records import CableOptions
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
from pipeline.segments.leftovers import drop_leftovers
from pipeline.segments.plan import Segment, cut
from pipeline.segments.survey_run import SegmentedRun
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
        folder_of = partial(_folder, start, only)
        chain = Chain(survey, options, folder_of(out), emit)
        write_json(chain.folder.path / "options.json", options, "run")
        last = only or "report"
        if last == "report":
            _load_page_early()
        chain.run("frames", pairs)
        segments = _segments(chain, options, pairs)
        if last == "frames":
            return f"{last} is done in {out}"
        drop_leftovers(out, segments)
        if len(segments) > 1:
            data = SegmentedRun(survey, options, chain, segments, folder_of).write(true, language, last)
        else:
            data = _in_one_piece(chain, pairs, last, true, language)
        if data is None:
            return f"{only} is done in {out}"
        drop_set_aside(out)
        emit(Event(stage="report", done=1, total=1))
    return _summary(data, out)


def _load_page_early() -> None:
    """Load Matplotlib, which takes its time, while frames are read, so that the report need not wait.

    The thread is no daemon: a refusal would end the interpreter in the middle of an import, which aborts.
    """
    Thread(target=import_module, args=("pipeline.report.page",)).start()


def _segments(chain: Chain, options: CableOptions, pairs: Path | None) -> tuple[Segment, ...]:
    """What the survey is cut into; pairs are of a model in one piece, and only rings can be tied."""
    segments = cut(len(chain.made["frames"][0].value), options.segments)
    return segments if chain.together and not pairs else segments[:1]


def _in_one_piece(
    chain: Chain, pairs: Path | None, last: str, truth: tuple[TruthStation, ...], language: Language
) -> ReportData | None:
    """All stages up to ``last``, and the product where that is the report."""
    found = run_cable(chain, pairs, STAGES[-1] if last == "report" else last)
    if found is None or last != "report":
        return None
    set_aside(chain.folder.path)
    return write_run(found, chain.folder, truth, language, chain.emit)


def _folder(start: str | None, only: str | None, out: Path, whole: Path | None = None) -> RunFolder:
    """The run folder, or that of one segment of the whole; what is made in it outdates both."""
    stages = (*STAGES[: STAGES.index("joint")], "joint_nominal", *STAGES[STAGES.index("joint") :], "report")
    first = "joint_nominal" if start == "joint" else start
    chosen = {"joint_nominal", "joint"} if only == "joint" else {only} if only else set()
    fresh = frozenset(stages[stages.index(first) :] if first else chosen)
    allowed = None if only in (None, "report") else frozenset(chosen)

    def outdated() -> None:
        for folder in (out, whole):
            if folder is not None:
                set_aside(folder)

    return RunFolder(out, fresh, allowed, before_making=outdated, root=whole)


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
