"""The verdict: every figure beside its bounds, as a table for people and as JSON for programs; pure."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from synth.gate.bounds import Bounds


@dataclass(frozen=True, kw_only=True)
class Line:
    """One figure of one scenario.

    Attributes:
        scenario, figure: which; the figure's name carries its unit.
        value: None where the run did not tell it.
        least, most: the bounds, both included.
        holds: is it there and between them?
    """

    scenario: str
    figure: str
    value: float | None
    least: float
    most: float
    holds: bool

    def sentence(self) -> str:
        """What is wrong with the figure."""
        if self.value is None:
            return f"{self.scenario}: {self.figure} is not there"
        side, bound = ("below", self.least) if self.value < self.least else ("above", self.most)
        return f"{self.scenario}: {self.figure} = {self.value:.4g} is {side} {bound:g}"


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Of the whole gate.

    Attributes:
        seed: that the surveys were rendered with.
        lines: a line for each scenario and figure.
        failures: scenario to the sentence of the step that failed; such a scenario has no figures.
    """

    seed: int
    lines: tuple[Line, ...]
    failures: Mapping[str, str]

    @property
    def complaints(self) -> tuple[str, ...]:
        """One sentence for everything that does not hold; none where the gate is passed."""
        failed = [f"{name}: {sentence}" for name, sentence in self.failures.items()]
        return (*failed, *(line.sentence() for line in self.lines if not line.holds))


def judge(
    scenario: str, figures: Mapping[str, float | None], bounds: Mapping[str, Bounds]
) -> tuple[Line, ...]:
    """Hold every bounded figure of a scenario against its bounds."""
    return tuple(
        Line(
            scenario=scenario,
            figure=name,
            value=figures.get(name),
            least=bound.least,
            most=bound.most,
            holds=bound.hold(figures.get(name)),
        )
        for name, bound in bounds.items()
    )


def verdict_json(verdict: Verdict) -> dict[str, Any]:
    """Plain values."""
    return {
        "format": 1,
        "seed": verdict.seed,
        "passed": not verdict.complaints,
        "lines": [asdict(line) for line in verdict.lines],
        "failures": dict(verdict.failures),
    }


def verdict_table(verdict: Verdict) -> str:
    """A row for each scenario and figure; what does not hold ends with the word OUT."""
    head = ("scenario", "figure", "least", "value", "most", "")
    rows = [
        (
            line.scenario,
            line.figure,
            f"{line.least:g}",
            "none" if line.value is None else f"{line.value:.4g}",
            f"{line.most:g}",
            "" if line.holds else "OUT",
        )
        for line in verdict.lines
    ]
    return "\n".join(_row(cells, [head, *rows]) for cells in (head, *rows)) + "\n"


def _row(cells: Sequence[str], table: Sequence[Sequence[str]]) -> str:
    """Words to the left, numbers to the right."""
    widths = [max(len(row[column]) for row in table) for column in range(len(cells))]
    words = [
        cell.ljust(width) if column in (0, 1, 5) else cell.rjust(width)
        for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
    ]
    return "  ".join(words).rstrip()
