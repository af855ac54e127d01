"""Report and tables to a folder of the person's own; and a cable from the library."""

from pathlib import Path

from driver import Steps
from sidebar import Person
from state import state


def export(person: Person, folder: Path) -> Steps:
    """The folder is typed into its field."""
    yield from person.panel("export")
    yield from person.write("export.folder", f"{folder}/", columns=(0.4,))
    assert Path(state().export.folder) == folder, state().export.folder
    yield from person.press("cabletwin.export_files", columns=(0.25,))
    yield from person.wait_for(lambda: (folder / "report.html").exists(), 20)
    yield from person.shot("16-export")
    yield from person.panel("export")
    yield from synthesise(person)


def synthesise(person: Person) -> Steps:
    """A cable and a ring from the library."""
    yield from person.panel("synthesise")
    yield 0.5
    yield from person.shot("17-synthesise")
