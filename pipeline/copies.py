"""Hand a finished run's files on: copies in a folder of one's choice, each whole or not at all.

Takes a run folder and the names of files; leaves the run as it is.
"""

import shutil
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.files import replacing


def finished_file(run_folder: Path, name: str) -> Path:
    """A file of a finished run.

    Raises:
        StageError: the run is not finished, or the file is gone.
    """
    if not (run_folder / "report.json").is_file():
        raise StageError("export", f"the run in {run_folder} is not finished", "reconstruct first")
    if not (run_folder / name).is_file():
        raise StageError("export", f"{run_folder / name} is gone", "make the report again: --from report")
    return run_folder / name


def copy_results(run_folder: Path, names: tuple[str, ...], target: Path) -> tuple[Path, ...]:
    """Copy files of a finished run, in place of older ones of the same names.

    Args:
        run_folder: of a finished run.
        names: of files in it.
        target: folder; made where it is missing.

    Raises:
        StageError: nothing is chosen, the run is not finished, a file is gone, or the folder is the run's own
            or cannot be written.
    """
    if not names:
        raise StageError("export", "no file is chosen", "choose at least one")
    sources = [finished_file(run_folder, name) for name in names]
    if target.resolve() == run_folder.resolve():
        raise StageError("export", f"{target} is the run folder itself", "choose another folder")
    for source in sources:
        with replacing(target / source.name, "export") as temporary:
            shutil.copyfile(source, temporary)
    return tuple(target / name for name in names)
