"""The report for people: one self-contained HTML page, in English and Chinese.

Takes a :class:`~pipeline.report.types.ReportData` and writes report.html.  Pictures, plots, the 3D model,
style and scripts are all inside; the page asks no network.  What a run does not have is left out.  The order
of the page stands in :func:`page_html`; the parts are in ``parts`` and ``tables``.
"""

from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from string import Template

from pipeline.core.files import write_bytes
from pipeline.report import parts
from pipeline.report.header import header
from pipeline.report.labels import LANGUAGES, Language
from pipeline.report.markup import Writer, escaped
from pipeline.report.relief_section import relief_section
from pipeline.report.segment_section import segment_section
from pipeline.report.types import ReportData
from pipeline.report.viewer import ViewerOptions

RUN_FILES = ("model.glb", "model.ply", "cloud.ply", "unrolled.png", "diameters.csv", "report.json")


@dataclass(frozen=True, kw_only=True)
class PageOptions:
    """How the page is written.

    Attributes:
        language: language that the page opens in; the other one is a click away.
        viewer: how much of the model the page carries.
        unrolled_max_pixels: the unrolled picture is reduced to this many pixels in the page.
        picture_max_side_px: longest side of the other pictures in the page.
        files: which of RUN_FILES lie beside the page and are linked from it.
    """

    language: Language = "en"
    viewer: ViewerOptions = field(default_factory=ViewerOptions)
    unrolled_max_pixels: int = 12_000_000
    picture_max_side_px: int = 960
    files: tuple[str, ...] = RUN_FILES

    def __post_init__(self) -> None:
        if self.language not in LANGUAGES:
            raise ValueError(f"language {self.language!r} is none of {', '.join(LANGUAGES)}")


def write_report_html(path: Path, data: ReportData, options: PageOptions | None = None) -> Path:
    """Write the page and give its path back.

    Raises:
        StageError: the path cannot be written.
    """
    return write_bytes(path, page_html(data, options or PageOptions()).encode(), "report")


def page_html(data: ReportData, options: PageOptions) -> str:
    """The whole page as one string."""
    writer = Writer(language=options.language)
    sections = [
        ("diameters", parts.diameters(writer, data)),
        ("model", parts.model(writer, data, options.viewer)),
        ("unrolled", parts.unrolled(writer, data, options.unrolled_max_pixels, options.picture_max_side_px)),
        ("relief", relief_section(writer, data.relief)),
        ("sections", parts.sections(writer, data)),
        ("triangulation", parts.triangulation(writer, data)),
        ("lens", parts.lens(writer, data, options.picture_max_side_px)),
        ("lens_effect", parts.lens_effect(writer, data)),
        ("mosaic", parts.mosaic(writer, data)),
        ("segments", segment_section(writer, data.segments)),
        ("resources", parts.resources(writer, data)),
        ("files", parts.file_list(writer, options.files)),
    ]
    present = [(key, body) for key, body in sections if body]
    links = "".join(writer.say(key, "a", f'href="#{key}"') for key, _ in present)
    main = "".join(f'<section id="{key}">{writer.say(key, "h2")}{body}</section>' for key, body in present)
    return Template(_resource("template.html")).substitute(
        language=options.language,
        title=f"{escaped(data.name)} · CableTwin",
        style=_resource("style.css"),
        header=header(writer, data),
        contents=links,
        main=main,
        close=writer.say("close", "button", 'class="close" type="button"'),
        point_at=writer.template("point_at", "span", 'class="where" hidden'),
        actual_size=writer.say("actual_size", "button", 'class="size" type="button"'),
        script=_resource("page.js"),
        viewer_script=f"<script>{_resource('viewer.js')}</script>" if data.mesh is not None else "",
    )


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
