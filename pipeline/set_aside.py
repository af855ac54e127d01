"""What an earlier run left for people to open must not pass for the result of a run that was refused.

Takes a run folder; moves the files that a person opens into its folder ``outdated``, as soon as anything they
rest on is made again or the run is refused.  Nothing is lost, and a run that comes to its end clears it away.
Leaves out the products of the stages, which carry stamps of their own.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.files import unwritable

OPENED_FILES = (
    *("report.json", "report.html", "diameters.csv", "model.glb", "model.ply", "cloud.ply"),
    *("unrolled.png", "radius_map.npz"),
    *("stations.csv", "residuals.csv", "nodes.csv", "columns.csv", "deflection.csv"),
    *("members.glb", "members.ply", "merged.ply"),
)
"""Of the whole cable or structure; report.json first, for it stands for a whole product."""

SCAN = "scan"
"""Folder about a laser scan that was held against the run (``join-scan``)."""
OUTDATED = "outdated"


def set_aside(run_folder: Path) -> None:
    """Move the files that a person opens to ``outdated``.

    Raises:
        StageError: they cannot be moved.
    """
    # a folder without products is no run folder, and its report.json is somebody else's
    if not (run_folder / "products").is_dir():
        return
    names = list(OPENED_FILES)
    if (run_folder / SCAN / "scan.json").is_file():
        shutil.rmtree(run_folder / OUTDATED / SCAN, ignore_errors=True)
        names.append(SCAN)
    for file in (run_folder / name for name in names):
        if not file.exists():
            continue
        try:
            (run_folder / OUTDATED).mkdir(exist_ok=True)
            os.replace(file, run_folder / OUTDATED / file.name)
        except FileNotFoundError:
            continue  # blocks are made side by side: another one was quicker
        except OSError as error:
            raise unwritable(file, error, "report") from error


def drop_set_aside(run_folder: Path) -> None:
    """Clear away what was set aside: the files that replace it are there."""
    shutil.rmtree(run_folder / OUTDATED, ignore_errors=True)


@contextmanager
def none_if_refused(run_folder: Path) -> Iterator[None]:
    """Set the files of an earlier run aside when the body refuses its input."""
    try:
        yield
    except StageError:
        with suppress(StageError):  # the refusal is what the person must read
            set_aside(run_folder)
        raise
