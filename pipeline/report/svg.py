"""From a matplotlib figure to an SVG that stands inline in a page.

Takes a :class:`matplotlib.figure.Figure` (no pyplot, no global state beyond a context), gives one ``<svg>``
element: no namespace, no fixed size, identifiers prefixed so that several can stand on one page, and every
text that is a known label carries both languages (``data-en``, ``data-zh``).
"""

import io
import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from pipeline.report.labels import TEXTS, Label, Language

INK = "#22303c"
QUIET = "#8a96a1"
GRID = "#e3e8ec"
# Okabe and Ito's colours, which colour-blind people can tell apart.
BLUE, VERMILLION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
# Stands between a label and a value in one text of a plot: an en space.
VALUE_GAP = "\u2002"

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "cabletwin",
    "font.size": 10,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "lines.linewidth": 1.6,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_PLOT_LABELS = {
    en: Label(en=en, zh=zh) for key, (en, zh) in TEXTS.items() if key.startswith(("plot_", "stage_"))
}


@contextmanager
def plot_style() -> Iterator[None]:
    """The one quiet style of all plots; make, draw and save the figure inside."""
    with mpl.rc_context(_STYLE):
        yield


def inline_svg(figure: Figure, name: str, title: Label, language: Language) -> str:
    """The figure as an ``<svg>`` element; ``name`` is unique on the page, ``title`` is read to the blind."""
    stream = io.StringIO()
    with warnings.catch_warnings():
        # The browser has Chinese fonts even where matplotlib, which only lays the text out, has none.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(stream, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    root = ET.fromstring(stream.getvalue())
    _drop_namespaces(root)
    for child in [child for child in root if child.tag == "metadata"]:
        root.remove(child)
    _prefix_identifiers(root, name)
    for text in root.iter("text"):
        _carry_both_languages(text, language)
    for size in ("width", "height", "version"):
        root.attrib.pop(size, None)
    root.set("role", "img")
    root.set("aria-label", title.text(language))
    return ET.tostring(root, encoding="unicode")


def _drop_namespaces(root: ET.Element) -> None:
    """An inline SVG needs none, and without them the page holds no address at all."""
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        for key in [key for key in element.attrib if key.startswith("{")]:
            element.set(key.rpartition("}")[2], element.attrib.pop(key))


def _prefix_identifiers(root: ET.Element, name: str) -> None:
    """Keep only the identifiers that something refers to, and make them the plot's own."""
    used = set()
    for element in root.iter():
        for key, value in list(element.attrib.items()):
            if key == "href" and value.startswith("#"):
                used.add(value[1:])
                element.set(key, f"#{name}-{value[1:]}")
            elif "url(#" in value:
                used.update(_REFERENCE.findall(value))
                element.set(key, _REFERENCE.sub(rf"url(#{name}-\1)", value))
    for element in root.iter():
        identifier = element.attrib.pop("id", None)
        if identifier in used:
            element.set("id", f"{name}-{identifier}")


def _carry_both_languages(text: ET.Element, language: Language) -> None:
    words, gap, value = (text.text or "").strip().partition(VALUE_GAP)
    known = _PLOT_LABELS.get(words)
    if known is None:
        return
    both = Label(en=f"{known.en}{gap}{value}", zh=f"{known.zh}{gap}{value}")
    text.set("data-en", both.en)
    text.set("data-zh", both.zh)
    text.text = both.text(language)
