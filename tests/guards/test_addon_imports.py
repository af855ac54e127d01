"""What an installed extension may import: Blender calls the rest a violation of policy, or crashes on it."""

import ast

from tests.guards.test_imports import ROOT, imports, offences, sources

HEAVY = {"av", "cv2", "matplotlib", "OpenEXR", "PIL", "scipy", "trimesh"}
ELSEWHERE = {"synth", "blend_assets", "tests", "tools"}
WITHOUT_BLENDER = {"jobs.py", "processes.py"}


def root(module):
    return module.split(".")[0]


def test_there_is_an_add_on_to_guard():
    assert len(sources("addon")) > 30
    found = {module for path in sources("addon") for module, _, _ in imports(path)}
    assert {"bpy", "pipeline.core.errors"} <= found


def test_what_cannot_live_in_blenders_process_is_not_imported():
    # Debian's Blender is linked with glog, of which pycolmap carries another: the whole program aborts
    assert offences(sources("addon"), lambda module: root(module) in {"pycolmap", *ELSEWHERE}) == []


def test_own_modules_are_imported_by_relative_names():
    own = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in sources("addon")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if (isinstance(node, ast.ImportFrom) and not node.level and root(node.module) in {"addon", "bl_ext"})
        or (isinstance(node, ast.Import) and any(root(a.name) in {"addon", "bl_ext"} for a in node.names))
    ]
    assert own == []


def test_the_path_of_blenders_python_is_left_alone():
    touched = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in sources("addon")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute)
        and node.attr in {"path", "modules"}
        and isinstance(node.value, ast.Name)
        and node.value.id == "sys"
    ]
    assert touched == []


def test_enabling_waits_for_no_heavy_package():
    early = [
        f"{path.relative_to(ROOT)}:{line} imports {module}"
        for path in sources("addon")
        for module, line, at_top in imports(path)
        if at_top and root(module) in HEAVY
    ]
    assert early == []


def test_following_a_job_needs_no_blender():
    files = [path for path in sources("addon") if path.name in WITHOUT_BLENDER]
    assert len(files) == len(WITHOUT_BLENDER)
    assert offences(files, lambda module: root(module) in {"bpy", "mathutils"}) == []
