"""A program run as a child with its words in a log: how it ended, when, and with which complaint.

Takes a command; gives :class:`Finished`.  Leaves out what the command is.
"""

import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

BEAT_S = 0.5


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A child that has ended.

    Attributes:
        failure: None where it ended with code 0, else its last sentence on stderr.
        seconds: wall-clock time.
    """

    failure: str | None
    seconds: float


def run_child(command: Sequence[str], log: Path, beat: Callable[[], None]) -> Finished:
    """Run a command to its end.

    Args:
        command: program and arguments.
        log: file that gets its stdout and stderr, after what is there already.
        beat: called every half second; what it raises ends the child too.
    """
    started = time.monotonic()
    with log.open("a+", encoding="utf-8", errors="replace") as words:
        words.write(f"$ {' '.join(command)}\n")
        words.flush()
        first = words.tell()
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=words, stderr=words)
        try:
            while (code := _ended(child)) is None:
                beat()
        finally:
            if child.poll() is None:
                child.terminate()
                child.wait()
        words.seek(first)
        failure = last_sentence(words.read(), code) if code != 0 else None
    return Finished(failure=failure, seconds=time.monotonic() - started)


def _ended(child: subprocess.Popen[bytes]) -> int | None:
    try:
        return child.wait(timeout=BEAT_S)
    except subprocess.TimeoutExpired:
        return None


def last_sentence(words: str, code: int) -> str:
    """The last line that was said, without the word error before it."""
    lines = [line.strip() for line in words.replace("\r", "\n").splitlines() if line.strip()]
    return lines[-1].removeprefix("error: ") if lines else f"ended with code {code} and no word"
