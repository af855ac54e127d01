"""Gross errors put together for reading: a target that was moved is one thing, however many stations saw it.

Takes the single observations; gives groups.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.steel.registration_records import GrossError, GrossKind


@dataclass(frozen=True, kw_only=True)
class GrossGroup:
    """Observations of one target that are wrong in one way.

    Attributes:
        errors: in the order of their stations' names; one for a misnamed target.
        together: stations that see it at the same displaced place, those whose sights are no gross error
            included.
    """

    errors: tuple[GrossError, ...]
    together: tuple[str, ...]

    @property
    def first(self) -> GrossError:
        """What stands for all of them."""
        return self.errors[0]


def grouped(gross: Sequence[GrossError]) -> tuple[GrossGroup, ...]:
    """Moved targets with all their stations, then the misnamed ones, each in the order of its name."""
    found: dict[tuple[str, ...], list[GrossError]] = {}
    for error in gross:
        alone = () if error.kind is GrossKind.MOVED else (error.station,)
        found.setdefault((error.kind.value, error.target, *sorted(error.together), *alone), []).append(error)
    groups = [
        GrossGroup(
            errors=tuple(sorted(errors, key=lambda error: error.station)),
            together=tuple(sorted({name for error in errors for name in (*error.together, error.station)})),
        )
        for errors in found.values()
    ]
    return tuple(sorted(groups, key=lambda group: (group.first.kind.value == "misnamed", group.first.target)))
