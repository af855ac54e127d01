"""A click on a row of a table leads to the thing."""

import bpy
import numpy as np
import pytest

from tests.addon.steel import case
from tests.addon.steel.scene import named


def test_tables_hold_the_runs_figures_eccentric_nodes_first(shown):
    assert [node.name for node in shown.nodes] == ["N02", "N03", "N01"]
    assert [node.significant for node in shown.nodes] == [True, True, False]
    column = shown.columns["A-1"]
    assert (column.deviation_mm, column.ratio) == pytest.approx((50, 100))
    assert (column.direction, column.over, shown.columns["A-2"].over) == ("north-east", True, False)
    assert (shown.sag_mm, shown.sag_limit_mm, shown.sag_node) == pytest.approx((12.5, 24.0, "N03"))


def looked_at():
    """Middle and distance of the 3D views."""
    areas = [a for w in bpy.context.window_manager.windows for a in w.screen.areas if a.type == "VIEW_3D"]
    assert areas
    return [(a.spaces.active.region_3d.view_location, a.spaces.active.region_3d.view_distance) for a in areas]


def test_clicking_a_column_selects_it_alone_and_frames_it(shown):
    named("Balls")["N01"].select_set(True)
    shown.column_index = 2
    assert [item.name for item in bpy.context.selected_objects] == ["B-1"]
    assert bpy.context.view_layer.objects.active.name == "B-1"
    for middle, distance in looked_at():
        assert np.allclose(middle, (0.0176, 6.0, 2.5), atol=0.01)
        assert 5 < distance < 12


def test_clicking_a_node_shows_its_ball_even_if_balls_were_hidden(shown):
    layers = bpy.context.view_layer.layer_collection.children["CableTwin"].children["Steel"].children
    layers["Balls"].hide_viewport = True
    shown.node_index = 1
    assert not layers["Balls"].hide_viewport
    assert [item.name for item in bpy.context.selected_objects] == ["N03"]
    for middle, distance in looked_at():
        assert np.allclose(middle, case.ball_place("N03"), atol=1e-5)
        assert 0.5 < distance < 2


def test_clicking_a_row_whose_object_a_person_deleted_does_nothing(shown):
    bpy.data.objects.remove(named("Columns")["A-2"])
    shown.column_index = 1
    assert bpy.context.selected_objects == []


def test_a_gross_error_is_found_by_its_button(shown):
    moved = [item.kind for item in shown.gross].index("moved")
    assert bpy.ops.cabletwin.steel_gross_show(index=moved) == {"FINISHED"}
    assert [item.name for item in bpy.context.selected_objects] == ["T15 moved"]
    with pytest.raises(RuntimeError, match="not known"):
        bpy.ops.cabletwin.steel_gross_show(index=99)
