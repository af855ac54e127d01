"""Gross errors that the run names against those that are there.

A moved target is named when any station's sight of it is (those before the move and those after it cannot
both be right, and which are fewer is left out); a misnamed one when the station's sight under either of the
two names is.
"""

from pipeline.evaluate.documents import Document
from pipeline.evaluate.steel.registration_errors import GrossVerdict


def compare_gross(report: Document, truth: Document) -> GrossVerdict:
    """Compare them."""
    found = [(row.text("station"), row.text("target"), row.text("kind")) for row in report.items("gross")]
    explained: set[int] = set()
    named: list[str] = []
    missed: list[str] = []
    for row in truth.items("gross"):
        mine = [n for n, sight in enumerate(found) if _is(sight, row)]
        explained.update(n for n, sight in enumerate(found) if _concerns(sight, row))
        (named if mine else missed).append(_words(row))
    false = [" ".join(sight) for n, sight in enumerate(found) if n not in explained]
    return GrossVerdict(named=tuple(named), missed=tuple(missed), false=tuple(false))


def _is(sight: tuple[str, str, str], row: Document) -> bool:
    return sight[2] == row.text("kind") and _concerns(sight, row)


def _concerns(sight: tuple[str, str, str], row: Document) -> bool:
    """Whether the sight that was named is spoilt by this gross error."""
    station, target, _ = sight
    if row.text("kind") == "moved":
        return target == row.text("target")
    names = {row.text("target"), *([row.text("called")] if "called" in row else [])}
    return station == row.text("station") and target in names


def _words(row: Document) -> str:
    if row.text("kind") == "moved":
        return f"moved {row.text('target')}"
    return f"misnamed {row.text('station')} {row.text('called') if 'called' in row else row.text('target')}"
