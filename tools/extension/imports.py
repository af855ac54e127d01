"""Absolute imports of the library made relative, which is how an installed extension must import.

Takes the text of a module and where it will lie in the extension; gives the text with ``from pipeline.x
import y`` written as ``from ..x import y``.  Only the module's name is touched, at the place where the parser
found it, so line numbers, comments and strings stay.  ``synth`` is not rewritten: it runs in a process of its
own, with the extension's folder on the path.
"""

import ast
import re
from pathlib import PurePosixPath

from tools.extension.errors import ExtensionError

LIBRARY = "pipeline"
_FROM = re.compile(rb"(from\s+)([\w.]+)")
_AS = re.compile(rb"import\s+([\w.]+)\s+as\s+(\w+)")


def make_relative(source: str, path: PurePosixPath) -> str:
    """The module's text with every import of the library relative.

    Args:
        source: text of the module.
        path: the file's place in the extension, such as ``operators/survey.py`` or ``pipeline/cable/run.py``.

    Raises:
        ExtensionError: an import that has no relative form (``import pipeline.core``).
    """
    lines = [line.encode() for line in source.splitlines(keepends=True)]
    package = path.parts[:-1]
    for node in ast.walk(ast.parse(source)):
        start = getattr(node, "col_offset", 0)
        if isinstance(node, ast.ImportFrom) and not node.level and _of_library(node.module):
            line = lines[node.lineno - 1]
            # only the name of the module changes, so another statement in the same line keeps its place
            lines[node.lineno - 1] = line[:start] + _FROM.sub(
                lambda found: found[1] + _relative(found[2].decode(), package).encode(), line[start:], count=1
            )
        elif isinstance(node, ast.Import) and any(_of_library(alias.name) for alias in node.names):
            line = lines[node.lineno - 1]
            if len(node.names) > 1 or not (found := _AS.match(line, start)):
                raise ExtensionError(
                    f"{path}:{node.lineno} has an import that cannot be made relative: write it as "
                    f"'from {LIBRARY}.module import name'"
                )
            parent, _, name = found[1].decode().rpartition(".")
            where = _relative(parent, package) if parent else "." * (len(package) + 1)
            words = f"from {where} import {name} as {found[2].decode()}"
            lines[node.lineno - 1] = line[:start] + words.encode() + line[found.end() :]
    return b"".join(lines).decode()


def absolute_imports(source: str) -> list[int]:
    """The lines in which a module imports the library by its absolute name."""
    return sorted(
        node.lineno
        for node in ast.walk(ast.parse(source))
        if (isinstance(node, ast.ImportFrom) and not node.level and _of_library(node.module))
        or (isinstance(node, ast.Import) and any(_of_library(alias.name) for alias in node.names))
    )


def _of_library(module: str | None) -> bool:
    return (module or "").split(".")[0] == LIBRARY


def _relative(module: str, package: tuple[str, ...]) -> str:
    """The relative name of a module, as seen from a package; one dot is the package itself."""
    target = tuple(module.split("."))
    shared = 0
    while shared < min(len(package), len(target)) and package[shared] == target[shared]:
        shared += 1
    return "." * (len(package) - shared + 1) + ".".join(target[shared:])
