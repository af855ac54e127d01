#!/bin/sh
# Make .venv with the pinned packages and this project in it.  Called by make, once for each requirements.lock.
set -eu
cd "$(dirname "$0")/.."

if ! .venv/bin/python -c 'import sys, pip; sys.exit(sys.version_info[:2] != (3, 13))' 2>/dev/null; then
    python=$(sh tools/find_python.sh)
    echo "Making .venv with $python"
    "$python" -m venv --clear .venv
fi

.venv/bin/python -m pip install --disable-pip-version-check --no-input --require-hashes -r requirements.lock

# the project itself: one line that adds this folder to the environment's path, so that
# "python -m pipeline" works from anywhere and always runs the source that lies here
.venv/bin/python - <<'END'
import sysconfig
from pathlib import Path

Path(sysconfig.get_path("purelib"), "cabletwin.pth").write_text(f"{Path.cwd()}\n", encoding="utf-8")
END
touch .venv/.ready
