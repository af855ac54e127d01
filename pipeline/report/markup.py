"""The small words of HTML: escaped texts in two languages, numbers, tables, figures.

Gives strings; everything that comes from outside is escaped here and nowhere else.
"""

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.report.labels import Label, Language, label

DASH = "–"
MINUS = "\u2212"


def number(value: float, digits: int) -> str:
    """The value with a true minus sign and that many decimals; a dash where it is not known."""
    return f"{value:.{digits}f}".replace("-", MINUS) if math.isfinite(value) else DASH


def signed(value: float, digits: int) -> str:
    """Like :func:`number`, with the sign written where there is one after rounding."""
    if round(value, digits) == 0:
        return number(0.0, digits)
    return f"{value:+.{digits}f}".replace("-", MINUS) if math.isfinite(value) else DASH


def thousands(value: float) -> str:
    """A whole number in groups of three."""
    return f"{value:,.0f}".replace(",", "\u202f") if math.isfinite(value) else DASH


def escaped(text: str) -> str:
    """The text, safe between tags and inside quoted attributes."""
    return html.escape(text, quote=True)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row of a table: a heading cell as a finished element, and plain values.

    Attributes:
        head: the ``<th>`` element.
        cells: texts, escaped here; a label where both languages differ.
        kind: class of the row, or "".
        tail: a finished last ``<td>`` element, or "".
    """

    head: str
    cells: Sequence[str | Label]
    kind: str = ""
    tail: str = ""


@dataclass(frozen=True, kw_only=True)
class Writer:
    """Writes HTML in one language and leaves the other one beside it, for the switch in the page."""

    language: Language

    def say(self, key: str, tag: str = "span", attributes: str = "", **values: str) -> str:
        """The label of that key as one element, its placeholders filled."""
        return self.element(label(key, **values), tag, attributes)

    def template(self, key: str, tag: str, attributes: str) -> str:
        """An empty element that carries the label of that key, placeholders and all, for a script to fill."""
        text = label(key, **{name: f"{{{name}}}" for name in ("angle", "position")})
        both = f'data-form-en="{escaped(text.en)}" data-form-zh="{escaped(text.zh)}"'
        return f"<{tag} {attributes} {both}></{tag}>"

    def element(self, text: Label, tag: str = "span", attributes: str = "") -> str:
        """A text in both languages as one element."""
        both = f'data-en="{escaped(text.en)}" data-zh="{escaped(text.zh)}"'
        space = " " if attributes else ""
        return f"<{tag}{space}{attributes} {both}>{escaped(text.text(self.language))}</{tag}>"

    def table(self, caption: str, head: Sequence[str], rows: Sequence[Row], note: str = "") -> str:
        """A table in a box that scrolls sideways on a narrow screen.

        Args:
            caption: element of the caption.
            head: cells of the first row, as finished ``<th>`` elements.
            rows: the body.
            note: element that stands below, or "".
        """
        body = "".join(self.row(row) for row in rows)
        first = "".join(head)
        table = f"<table><thead><tr>{first}</tr></thead><tbody>{body}</tbody></table>"
        return f'<figure class="table">{caption}<div class="scroll">{table}</div>{note}</figure>'

    def row(self, row: Row) -> str:
        """One row of a table."""
        cells = "".join(
            self.element(cell, "td") if isinstance(cell, Label) else f"<td>{escaped(cell)}</td>"
            for cell in row.cells
        )
        kind = f' class="{row.kind}"' if row.kind else ""
        return f"<tr{kind}>{row.head}{cells}{row.tail}</tr>"

    def figure(self, content: str, caption: str, kind: str = "") -> str:
        """A plot or picture with its caption below."""
        return f'<figure class="{kind or "plot"}">{content}{caption}</figure>'
