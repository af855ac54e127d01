"""The programs as a person starts them: in a process of their own, with exit code, both streams and time."""

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg", "PYTHONUNBUFFERED": "1"}


@dataclass(frozen=True)
class Command:
    code: int
    stdout: str
    stderr: str
    seconds: float

    @property
    def events(self):
        return [json.loads(line) for line in self.stderr.splitlines() if line.startswith("{")]


def line_of(module, words):
    return [sys.executable, "-m", module, *(str(word) for word in words)]


def pipeline(*words, largest_file_bytes=None):
    """Run ``python -m pipeline WORDS``; a small largest file is what a full disk looks like."""
    return _run("pipeline", words, largest_file_bytes)


def synth(*words):
    return _run("synth", words)


def start_pipeline(*words):
    """Start it and come back at once."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(line_of("pipeline", words), cwd=ROOT, env=ENVIRONMENT, **pipes)


def _run(module, words, largest_file_bytes=None):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file_bytes, largest_file_bytes))

    began = time.monotonic()
    done = subprocess.run(
        line_of(module, words),
        cwd=ROOT,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        preexec_fn=limit if largest_file_bytes else None,
    )
    return Command(done.returncode, done.stdout, done.stderr, time.monotonic() - began)
