"""Long work in a process of its own: the pipeline's command line, followed through its log.

Takes a command; gives its events as they come, one JSON object a line, and what it said at the end.  No
thread and no pipe: the process writes to a file beside its results, a log for people as well.  Needs no bpy.
"""

import atexit
import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.events import Event

from .library import environment
from .processes import PATIENCE_S, ask_to_stop, end, start_options


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a job ended.

    Attributes:
        code: of the process; 0 done, 130 interrupted.
        said: its results on stdout.
        failure: the sentence that it failed with, or "".
    """

    code: int
    said: str
    failure: str


class Job:
    """One running process.

    Args:
        command: program and arguments.
        log: file that gets its events and messages; what it prints lies beside it, with the ending .out.
        more: further variables of its environment.

    Attributes:
        log: the same file.

    Raises:
        StageError: the process cannot be started or the log not be written.
    """

    def __init__(self, command: list[str], log: Path, more: Mapping[str, str] | None = None) -> None:
        self.log, self._out = log, log.with_suffix(".out")
        try:
            log.parent.mkdir(parents=True, exist_ok=True)
            with log.open("wb") as errors, self._out.open("wb") as out:
                self._process = subprocess.Popen(
                    command,
                    env={**environment(), **(more or {})},
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=errors,
                    **start_options(),
                )
        except OSError as error:
            raise StageError(
                "run",
                f"cannot start the reconstruction in {log.parent} ({error.strerror})",
                "choose another run folder",
            ) from error
        self._read, self._rest = 0, b""
        self._words: list[str] = []
        atexit.register(self.kill)

    def events(self) -> list[Event]:
        """What has been told since the last call."""
        with self.log.open("rb") as file:
            file.seek(self._read)
            fresh = file.read()
        self._read += len(fresh)
        *lines, self._rest = (self._rest + fresh).split(b"\n")
        found = [_event(line) for line in lines if line.strip()]
        self._words += [f for f in found if isinstance(f, str)]
        return [f for f in found if isinstance(f, Event)]

    def running(self) -> bool:
        """Whether the process still works."""
        return self._process.poll() is None

    def stop(self) -> None:
        """Ask the process to end; it keeps what is finished."""
        if self.running():
            ask_to_stop(self._process)

    def kill(self) -> None:
        """End it for good, and wait until it is gone."""
        self.stop()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            end(self._process)
        atexit.unregister(self.kill)

    def outcome(self) -> Outcome:
        """How it ended; waits until it has."""
        code = self._process.wait()
        atexit.unregister(self.kill)
        self.events()
        failure = (
            "" if code in (0, 130) else _failure([*self._words, self._rest.decode(errors="replace")], code)
        )
        return Outcome(
            code=code, said=self._out.read_text(encoding="utf-8", errors="replace"), failure=failure
        )


def pipeline_command(python: Path, *words: str) -> list[str]:
    """The command line of the staged pipeline."""
    return [str(python), "-m", "pipeline", *words]


def _event(line: bytes) -> Event | str:
    text = line.decode(errors="replace")
    if text.startswith("{"):
        try:
            return Event(**json.loads(text))
        except (ValueError, TypeError):
            return text
    return text


def _failure(words: list[str], code: int) -> str:
    """The sentence behind ``error:``, or the last thing that was said."""
    said = [w.strip() for w in words if w.strip()]
    told = [w.removeprefix("error:").strip() for w in said if w.startswith("error:")]
    if told:
        return told[-1]
    where = f"the process ended with code {code}"
    if sys.platform != "win32" and code == -9:
        return (
            "the system ended the process, probably for want of memory; close other programs and run again."
        )
    return f"{where}: {said[-1]}" if said else f"{where} and said nothing"
