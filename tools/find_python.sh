#!/bin/sh
# Print the path of a Python 3.13 that can make virtual environments; say in one sentence what to do without one.
# PYTHON=... names one by hand.  A version manager's shim may stand on PATH and fail: each candidate is run.
set -u

works() {
    "$1" -c 'import sys, ensurepip, venv; sys.exit(sys.version_info[:2] != (3, 13))' >/dev/null 2>&1
}

found() {
    # the interpreter itself, not the shim that leads to it: shims listen to files in the current folder
    "$1" -c 'import sys; print(sys.executable)'
    exit 0
}

try() {
    for candidate in "$@"; do
        if [ -x "$candidate" ] && works "$candidate"; then found "$candidate"; fi
    done
}

on_path() {
    old_ifs=$IFS
    IFS=:
    set -f
    for folder in $PATH; do
        IFS=$old_ifs
        try "${folder:-.}/$1"
    done
    set +f
    IFS=$old_ifs
}

if [ -n "${PYTHON:-}" ]; then
    if works "$PYTHON"; then found "$PYTHON"; fi
    echo "PYTHON=$PYTHON is no Python 3.13 with venv; name one that is, or leave PYTHON out." >&2
    exit 1
fi

home=${HOME:-.}
share=${XDG_DATA_HOME:-$home/.local/share}

on_path python3.13
on_path python3
on_path python

# version managers keep their Pythons in folders of their own, whether or not they are active
try "${PYENV_ROOT:-$home/.pyenv}"/versions/3.13*/bin/python3.13
try "${MISE_DATA_DIR:-$share/mise}"/installs/python/3.13*/bin/python3.13
try "${ASDF_DATA_DIR:-$home/.asdf}"/installs/python/3.13*/bin/python3.13
for root in "${CONDA_PREFIX:-}" "${MAMBA_ROOT_PREFIX:-}" \
    "$home"/miniconda3 "$home"/anaconda3 "$home"/miniforge3 "$home"/mambaforge "$home"/micromamba; do
    if [ -n "$root" ]; then try "$root"/bin/python3.13 "$root"/envs/*/bin/python3.13; fi
done
if command -v brew >/dev/null 2>&1; then try "$(brew --prefix 2>/dev/null)"/opt/python@3.13/bin/python3.13; fi
try "${UV_PYTHON_INSTALL_DIR:-$share/uv/python}"/cpython-3.13*/bin/python3.13

for uv in "$(command -v uv 2>/dev/null)" "$home"/.local/bin/uv "$home"/.cargo/bin/uv; do
    if [ -n "$uv" ] && [ -x "$uv" ]; then
        try "$("$uv" python find --no-python-downloads 3.13 2>/dev/null)"
        echo "No Python 3.13 here yet; uv installs one." >&2
        "$uv" python install 3.13 >&2 || continue
        try "$("$uv" python find --no-python-downloads 3.13 2>/dev/null)"
        try "$("$uv" python dir 2>/dev/null)"/cpython-3.13*/bin/python3.13
    fi
done

echo "CableTwin needs Python 3.13 and found none; install it (python.org, your package manager with" \
    "its venv package, pyenv, mise or uv) or name it: make setup PYTHON=path/to/python3.13" >&2
exit 1
