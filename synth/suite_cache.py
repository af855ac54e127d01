"""What a suite need not make again: pictures that a sibling case has, and runs that are up to date.

Takes folders and specifications; makes hard links and a small note beside each run.  Leaves out starting
anything.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from synth.files import write_text
from synth.spec import Spec
from synth.stamps import PICTURES, WORK, pictures_stamp
from synth.truth import source_name

PIPELINE = Path(__file__).parents[1] / "pipeline"
NOTE = "made.json"


def share_pictures(spec: Spec, survey: Path, out: Path) -> Path | None:
    """Link the videos of a whole rendered case that differs in name and claims only.

    Nothing is done where the case has a survey already, or frames of another specification: then rendering
    sorts it out.

    Args:
        spec: the case's, with its seed.
        survey: the case's folder, to be rendered into.
        out: where the other cases are, as SCENARIO/seed-N/survey.

    Returns:
        The folder that the pictures come from, None where none has them.
    """
    stamp, stamp_file = pictures_stamp(spec), survey / PICTURES
    if (survey / "survey.toml").exists() or (stamp_file.exists() and stamp_file.read_text() != stamp):
        return None
    for sibling in sorted(out.glob("*/seed-*/survey")):
        if sibling != survey and _is_whole(sibling, stamp):
            stamp_file.parent.mkdir(parents=True, exist_ok=True)
            write_text(stamp_file, stamp)
            for name in (*_sources(spec), "depth", f"{WORK}/texture.png"):
                _link(sibling / name, survey / name)
            return sibling
    return None


def survey_digest(survey: Path) -> str:
    """Digest of what a run reads: survey.toml, and the stamp of its pictures."""
    return _digest(survey / name for name in ("survey.toml", PICTURES))


def program_digest() -> str:
    """Digest of the modules that decide a run's figures: all of pipeline but what judges it."""
    modules = sorted(p for p in PIPELINE.rglob("*.py") if p.relative_to(PIPELINE).parts[0] != "evaluate")
    return _digest(modules)[:12]


def note_run(folder: Path, seconds: float, survey: str, program: str) -> None:
    """Note of which survey and by which program the case's run was made, and how long it took."""
    write_text(folder / NOTE, json.dumps({"survey": survey, "program": program, "seconds": seconds}))


def forget_run(folder: Path) -> None:
    """Take the run and its note away."""
    (folder / NOTE).unlink(missing_ok=True)
    shutil.rmtree(folder / "run", ignore_errors=True)


def kept_seconds(folder: Path, survey: str, program: str) -> float | None:
    """How long the case's run took, None unless it is whole and of this survey and program."""
    note = read_json(folder / NOTE)
    same = note.get("survey") == survey and note.get("program") == program
    if not same or not (folder / "run" / "report.json").exists():
        return None
    return float(note["seconds"])


def read_json(path: Path) -> dict[str, Any]:
    """The object in a file, empty where there is none."""
    if not path.exists():
        return {}
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def _is_whole(survey: Path, stamp: str) -> bool:
    stamp_file = survey / PICTURES
    return (survey / "survey.toml").exists() and stamp_file.exists() and stamp_file.read_text() == stamp


def _sources(spec: Spec) -> list[str]:
    return [source_name(spec, block) for block in range(len(spec.blocks))]


def _link(source: Path, target: Path) -> None:
    """A hard link of a file, or of all files in a folder; a copy where the disk knows no links."""
    if source.is_dir():
        for file in sorted(source.iterdir()):
            _link(file, target / file.name)
    elif source.exists() and not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(source, target)
        except OSError:
            temporary = target.with_name(f"{target.stem}.part{target.suffix}")
            shutil.copy2(source, temporary)
            temporary.replace(target)


def _digest(files: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for file in files:
        content = file.read_bytes() if file.exists() else b""
        found.update(f"{file.name} {len(content)} ".encode() + content)
    return found.hexdigest()
