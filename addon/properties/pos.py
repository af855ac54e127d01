"""State of the area *pos*: which rows of the shown block's POS file found their frame."""

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from pipeline.cable.pos_file import PosMatch

MOST_MISSING = 200
"""Of the frames without a row no more than this are listed."""


class CableTwinPosRow(bpy.types.PropertyGroup):
    """A row of the file, or a frame without one; its ``name`` is the row's."""

    frame: bpy.props.IntProperty(name="Frame", description="Number of the frame in its video", default=-1)
    state: bpy.props.EnumProperty(
        name="State",
        description="What became of this row",
        items=(
            ("MATCHED", "Matched", "The row has found its frame"),
            ("NO_FRAME", "No such frame", "The name is no frame of this block"),
            ("TAKEN", "Named twice", "An earlier row names the same frame"),
            ("NO_ROW", "No row", "The file says nothing of this frame"),
        ),
    )


class CableTwinPos(bpy.types.PropertyGroup):
    """What a POS file was found to hold when it was last looked at."""

    rows: bpy.props.CollectionProperty(type=CableTwinPosRow)
    row_index: bpy.props.IntProperty(name="Row", description="The row that is chosen")
    block: bpy.props.StringProperty(description="Name of the block whose file was looked at")
    filepath: bpy.props.StringProperty(description="The file that was looked at", subtype="FILE_PATH")
    matched: bpy.props.IntProperty(name="Matched", description="Rows that found their frame")
    strangers: bpy.props.IntProperty(name="Without a frame", description="Rows that found none")
    missing: bpy.props.IntProperty(name="Without a row", description="Frames of the video without a row")
    problem: bpy.props.StringProperty(description="What the reconstruction would refuse the file for")

    def take(self, block: str, filepath: str, match: "PosMatch", problem: str) -> None:
        """Keep what the panel shows of a file."""
        from pipeline.cable.pos_file import NO_FRAME, TAKEN

        states = {NO_FRAME: "NO_FRAME", TAKEN: "TAKEN"}
        self.block, self.filepath, self.problem = block, filepath, problem
        self.rows.clear()
        for name, frame in zip(match.names, match.frames, strict=True):
            item = self.rows.add()
            item.name, item.frame, item.state = name, frame, states.get(frame, "MATCHED")
        for frame in match.without_row[:MOST_MISSING]:
            item = self.rows.add()
            item.name, item.frame, item.state = "–", frame, "NO_ROW"
        self.matched = sum(frame >= 0 for frame in match.frames)
        self.strangers, self.missing = len(match.names) - self.matched, len(match.without_row)
        self.row_index = 0


classes = (CableTwinPosRow, CableTwinPos)
