"""A finished run shown in the scene, and the extension's own library, for tests of what is done with it."""

import importlib

import bpy

from tests.addon.conftest import MODULE


def library(name):
    """A module of the installed extension, "pipeline.joining" or "results.picking"."""
    return importlib.import_module(f"{MODULE}.{name}")


def show(survey, run, folder):
    """Put the survey, saved anew in ``folder``, and its run into an empty file; gives the file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    assert bpy.ops.cabletwin.survey_open(filepath=str(survey / "survey.toml")) == {"FINISHED"}
    assert bpy.ops.cabletwin.survey_save(filepath=str(folder / "survey.toml")) == {"FINISHED"}
    bpy.context.scene.cabletwin.run.folder = str(run)
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shown.blend"))
    return folder / "shown.blend"


def opened(path):
    """Open a file; gives the scene's state."""
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    return bpy.context.scene.cabletwin


def moved(state, run, folder):
    """The same with a survey file and a run folder of the test's own."""
    assert bpy.ops.cabletwin.survey_save(filepath=str(folder / "survey.toml")) == {"FINISHED"}
    state.run.folder = state.results.folder = str(run)
    return state


def objects(kind):
    """Objects of the scene's collection of that kind, by the block they belong to; marks by their names."""
    found = library("results.collections").existing(bpy.context.scene, kind)
    return {o.name if kind == "Pairs" else o["cabletwin_block"]: o for o in found.objects} if found else {}


def named(kind):
    """Objects of the scene's collection of that kind by their names."""
    found = library("results.collections").existing(bpy.context.scene, kind)
    return {o.name: o for o in found.objects} if found else {}


def reloaded(path):
    """Save, start an empty file, open the saved one; gives the scene's state."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    return opened(path)
