"""Imports go one way: addon and synth may import pipeline, never the reverse; bpy stays at the rim."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("pipeline", "synth", "addon", "blend_assets")
BLENDER = {"bpy", "bmesh", "mathutils", "bpy_extras", "bl_ext", "gpu", "blf"}
BLENDER_ROOMS = {"synth", "addon", "blend_assets"}
TYPES_ONLY = {"pipeline.core.vocabulary", "pipeline.core.errors", "pipeline.core.events"}
PLUMBING = {"pipeline.core.options"}  # strict reading of tables: no formula either


def sources(*packages):
    return [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]


def imports(path):
    """(module, line, is it at the top of the file) of all imports, relative ones written out."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno, node in tree.body) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            package = path.relative_to(ROOT).parts[: -node.level] if node.level else ()
            yield (
                ".".join([*package, *([node.module] if node.module else [])]),
                node.lineno,
                node in tree.body,
            )


def offences(paths, forbidden):
    return [
        f"{path.relative_to(ROOT)}:{line} imports {module}"
        for path in paths
        for module, line, _ in imports(path)
        if forbidden(module)
    ]


def test_there_is_something_to_guard():
    assert len(sources("pipeline")) > 20
    assert any(module == "numpy" for path in sources("pipeline") for module, _, _ in imports(path))


def test_pipeline_imports_neither_synth_nor_addon_nor_blender():
    forbidden = {"synth", "addon", "blend_assets", "tests", *BLENDER}
    assert offences(sources("pipeline"), lambda module: module.split(".")[0] in forbidden) == []


def test_blender_is_imported_at_the_rim_only():
    elsewhere = [p for p in sources(*PACKAGES) if p.relative_to(ROOT).parts[0] not in BLENDER_ROOMS]
    assert elsewhere
    assert offences(elsewhere, lambda module: module.split(".")[0] in BLENDER) == []


def test_core_knows_no_stage():
    stages = ("pipeline.cable", "pipeline.steel", "pipeline.report", "pipeline.evaluate")
    core = [path for path in sources("pipeline") if path.relative_to(ROOT).parts[1] == "core"]
    assert len(core) > 5
    assert offences(core, lambda module: module.startswith(stages)) == []


def test_synth_shares_types_with_the_pipeline_but_no_formula():
    def formula(module):
        return module.split(".")[0] == "pipeline" and module not in TYPES_ONLY | PLUMBING

    assert offences(sources("synth"), formula) == []


def test_pycolmap_is_never_loaded_before_cv2():
    # the other order crashes when images are written (shared/design.md, section 6)
    for path in sources("pipeline", "synth"):
        lines = {module: line for module, line, _ in imports(path) if module in ("cv2", "pycolmap")}
        if "pycolmap" in lines:
            assert lines.get("cv2", 10**9) < lines["pycolmap"], f"{path.relative_to(ROOT)}: import cv2 first"


@pytest.mark.parametrize("package", PACKAGES)
def test_only_a_command_line_prints(package):
    for path in sources(package):
        if path.name in ("__main__.py", "build.py"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            printing = (
                isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
            )
            assert not printing, f"{path.relative_to(ROOT)}:{node.lineno} prints"


@pytest.mark.parametrize("package", PACKAGES)
def test_nothing_asserts_or_swallows(package):
    for path in sources(package):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            where = f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
            assert not isinstance(node, ast.Assert), f"{where} asserts"
            if isinstance(node, ast.ExceptHandler):
                names = (
                    {n.id for n in ast.walk(node.type) if isinstance(n, ast.Name)} if node.type else {"all"}
                )
                assert names.isdisjoint({"all", "Exception", "BaseException"}), f"{where} catches too much"
