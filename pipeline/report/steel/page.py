"""The steel report for people: one self-contained HTML page, in English and Chinese.

Takes a :class:`SteelReport`; the order of the page stands in :func:`page_html`, its parts in ``sections``.
Frame, style and language switch are the cable report's.
"""

from importlib.resources import files
from pathlib import Path
from string import Template

from pipeline.core.files import write_bytes
from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.report.labels import Language
from pipeline.report.markup import Writer, escaped
from pipeline.report.steel import sections
from pipeline.report.steel.header import header
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.truth_section import truth_section


def write_page(
    path: Path,
    report: SteelReport,
    truth: SteelEvaluation | None,
    beside: tuple[str, ...],
    language: Language,
) -> Path:
    """Write the page and give its path back.

    Raises:
        StageError: the path cannot be written.
    """
    return write_bytes(path, page_html(report, truth, beside, language).encode(), "report")


def page_html(
    report: SteelReport, truth: SteelEvaluation | None, beside: tuple[str, ...], language: Language
) -> str:
    """The whole page as one string.

    Args:
        report: what it shows.
        truth: the evaluation, where truth is known.
        beside: names of the files that lie beside the page.
        language: that it opens in; the other one is a click away.
    """
    writer = Writer(language=language)
    parts = [
        ("steel_registration", sections.registration(writer, report)),
        ("steel_chain", sections.chain(writer, report, truth)),
        ("steel_model", sections.structure(writer, report)),
        ("steel_columns", sections.columns(writer, report)),
        ("steel_nodes", sections.nodes(writer, report)),
        ("steel_deflection", sections.deflection(writer, report)),
        ("steel_fusion", sections.fusion(writer, report)),
        ("steel_truth", truth_section(writer, truth)),
        ("steel_paper", sections.beside_the_paper(writer, report)),
        ("resources", sections.resources(writer, report)),
        ("files", sections.file_list(writer, report, beside)),
    ]
    present = [(key.removeprefix("steel_"), key, body) for key, body in parts if body]
    links = "".join(writer.say(key, "a", f'href="#{name}"') for name, key, _ in present)
    main = "".join(
        f'<section id="{name}">{writer.say(key, "h2")}{body}</section>' for name, key, body in present
    )
    viewer = f"<script>{_own('viewer.js')}</script>" if 'id="viewer-data"' in main else ""
    return Template(_shared("template.html")).substitute(
        language=language,
        title=f"{escaped(report.name)} · CableTwin",
        style=_shared("style.css") + _own("steel.css"),
        header=header(writer, report),
        contents=links,
        main=main,
        close=writer.say("close", "button", 'class="close" type="button"'),
        point_at=writer.template("point_at", "span", 'class="where" hidden'),
        actual_size=writer.say("actual_size", "button", 'class="size" type="button"'),
        script=_shared("page.js"),
        viewer_script=viewer,
    )


def _shared(name: str) -> str:
    return files("pipeline.report").joinpath(name).read_text(encoding="utf-8")


def _own(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
