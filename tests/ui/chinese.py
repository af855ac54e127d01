"""An installed extension in Chinese in a Blender that was built without languages, to see its panels.

Puts the catalogue's text in place of each English one in its
source.  What Blender itself says stays English.  For looking only: never done to what is handed on.
"""

import ast
from pathlib import Path

from tests.guards.test_translations import catalogue, shown

ELSEWHERE = {"pipeline", "synth", "wheels", "translations", "assets"}


def rewrite_all(folder: Path) -> None:
    """Rewrite the extension that is installed in ``folder``."""
    known = catalogue()
    for path in folder.rglob("*.py"):
        if path.relative_to(folder).parts[0] not in ELSEWHERE:
            rewrite(path, known)


def rewrite(path: Path, known: dict[str, str]) -> None:
    """Put Chinese in place of what this file shows."""
    source = path.read_text(encoding="utf-8")
    wanted = {text for text in shown(path) if text in known}
    nodes = list(ast.walk(ast.parse(source)))
    # what a table is asked by is not shown
    keys = {id(key) for node in nodes if isinstance(node, ast.Dict) for key in node.keys}
    found = [
        node
        for node in nodes
        if isinstance(node, ast.Constant) and node.value in wanted and id(node) not in keys
    ]
    lines = source.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    data = source.encode()
    for node in sorted(found, key=lambda n: (n.lineno, n.col_offset), reverse=True):
        first = starts[node.lineno - 1] + node.col_offset
        last = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
        data = data[:first] + repr(known[node.value]).encode() + data[last:]
    path.write_bytes(data)
