"""Imports of the library become relative, and nothing else of a module changes."""

import ast
from pathlib import Path, PurePosixPath

import pytest

from tools.extension.errors import ExtensionError
from tools.extension.imports import absolute_imports, make_relative

ROOT = Path(__file__).parents[3]


def relative(source, path):
    return make_relative(source, PurePosixPath(path))


@pytest.mark.parametrize(
    ("path", "line", "expected"),
    [
        (
            "__init__.py",
            "from pipeline.core.errors import StageError",
            "from .pipeline.core.errors import StageError",
        ),
        ("jobs.py", "from pipeline import product", "from .pipeline import product"),
        ("operators/survey.py", "from pipeline.cable import survey", "from ..pipeline.cable import survey"),
        ("pipeline/product.py", "from pipeline.core.files import x", "from .core.files import x"),
        ("pipeline/product.py", "from pipeline import cable", "from . import cable"),
        ("pipeline/cable/run.py", "from pipeline.cable.pos import x", "from .pos import x"),
        ("pipeline/cable/run.py", "from pipeline.cable import pos", "from . import pos"),
        ("pipeline/cable/run.py", "from pipeline.core.errors import x", "from ..core.errors import x"),
        ("pipeline/cable/run.py", "from pipeline import product", "from .. import product"),
        ("pipeline/cable/run.py", "import pipeline.core.lens as lens", "from ..core import lens as lens"),
        ("jobs.py", "import pipeline as library", "from . import pipeline as library"),
    ],
)
def test_each_form_from_each_place(path, line, expected):
    assert relative(f"{line}\n", path) == f"{expected}\n"


def test_other_modules_comments_and_strings_stay():
    source = (
        '"""Runs from pipeline.core import x."""\n'
        "import numpy as np\n"
        "from pipelines.core import y  # from pipeline.core import z\n"
        "from .pipeline import own\n"
        'words = "from pipeline.core import x"\n'
    )
    assert relative(source, "jobs.py") == source


def test_imports_inside_functions_over_lines_and_behind_other_statements():
    source = (
        "def work():\n"
        "    name = 'ä'; from pipeline.core.lens import (  # why\n"
        "        Lens,\n"
        "    )\n"
        "    return Lens\n"
    )
    expected = source.replace("from pipeline.core.lens", "from ..pipeline.core.lens")
    assert relative(source, "operators/lens.py") == expected


def test_windows_line_ends_stay():
    assert (
        relative("x = 1\r\nfrom pipeline.a import b\r\n", "jobs.py")
        == "x = 1\r\nfrom .pipeline.a import b\r\n"
    )


@pytest.mark.parametrize(
    "line", ["import pipeline", "import pipeline.core.lens", "import json, pipeline.core as c"]
)
def test_an_import_without_a_relative_form_is_refused(line):
    with pytest.raises(
        ExtensionError, match=r"^operators/lens\.py:2 has an import that cannot be made relative"
    ):
        relative(f"import os\n{line}\n", "operators/lens.py")


def test_the_whole_library_and_add_on_mean_the_same_modules_afterwards():
    """Resolved as Python does, the new names are the old ones, below the extension's name."""
    sources = [(p, p.relative_to(ROOT)) for p in (ROOT / "pipeline").rglob("*.py")]
    sources += [(p, p.relative_to(ROOT / "addon")) for p in (ROOT / "addon").rglob("*.py")]
    changed = 0
    for path, place in sources:
        source = path.read_text(encoding="utf-8")
        made = relative(source, place.as_posix())
        assert absolute_imports(made) == []
        package = ["ext", *place.parts[:-1]]
        for old, new in zip(ast.walk(ast.parse(source)), ast.walk(ast.parse(made)), strict=True):
            if isinstance(old, ast.ImportFrom) and not old.level and old.module.split(".")[0] == "pipeline":
                base = package[: len(package) - new.level + 1]
                assert ".".join([*base, *([new.module] if new.module else [])]) == f"ext.{old.module}"
                changed += 1
            else:
                assert type(old) is type(new)
    assert changed > 100
