"""What survey.toml says, as properties: cable, robot, stations; a camera is a :mod:`.block`."""

import math

import bpy

from . import shared
from .block import CableTwinBlock, redraw_lens, redraw_setup


class CableTwinStation(bpy.types.PropertyGroup):
    """A place where the diameter is wanted; its ``name`` is the station's."""

    position: bpy.props.FloatProperty(
        name="Position",
        description="Along the axis from the first frame",
        subtype="DISTANCE",
        unit="LENGTH",
        min=0,
        precision=4,
        step=1,
        update=redraw_setup,
    )
    provisional_mm: bpy.props.FloatProperty(
        description="Diameter of the profile there until the station is measured; 0 unknown"
    )


class CableTwinSurvey(bpy.types.PropertyGroup):
    """The survey of a scene."""

    filepath: bpy.props.StringProperty(
        name="Survey file", description="The survey.toml of this scene", subtype="FILE_PATH"
    )
    written: bpy.props.StringProperty(
        description="The survey as the file holds it (JSON): keeps digits and options that no property holds"
    )
    name: bpy.props.StringProperty(name="Name", description="Name of the survey", default="survey")
    travel: bpy.props.FloatProperty(
        name="Travel",
        description="Path of the robot between the first and the last frame: it gives the model its scale",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.46,
        min=0,
        precision=4,
        update=redraw_setup,
    )
    travel_sigma_mm: bpy.props.FloatProperty(
        name="Its sigma (mm)",
        description="How well the travel is known, one standard deviation in millimetres",
        default=0.05,
        min=0,
        precision=3,
    )
    use_diameter: bpy.props.BoolProperty(
        name="Nominal diameter",
        description="Narrows the search, never enters a result",
        default=True,
        update=redraw_setup,
    )
    diameter: bpy.props.FloatProperty(
        name="Diameter",
        description="Nominal diameter of the cable",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.11,
        min=0.001,
        precision=4,
        update=redraw_setup,
    )
    standoff: shared.standoff(redraw_setup)
    synchronised: shared.synchronised()
    blocks: bpy.props.CollectionProperty(type=CableTwinBlock)
    block_index: bpy.props.IntProperty(
        name="Block", description="The block that is shown", update=redraw_lens
    )
    stations: bpy.props.CollectionProperty(type=CableTwinStation)
    station_index: bpy.props.IntProperty(name="Station", description="The station that is shown")

    def block(self) -> CableTwinBlock | None:
        """The block that is shown, or None."""
        return self.blocks[self.block_index] if 0 <= self.block_index < len(self.blocks) else None


def add_block(survey: CableTwinSurvey, count: int = 4) -> CableTwinBlock:
    """A further block, a quarter turn (or what ``count`` says) on from the last one."""
    number = len(survey.blocks)
    block = survey.blocks.add()
    block.name = f"Block{number + 1}"
    block.angle = (math.tau / count * number) % math.tau
    survey.block_index = number
    return block


def add_station(survey: CableTwinSurvey, position_m: float) -> CableTwinStation:
    """A further station, with the first name that is free; it becomes the one that is shown."""
    number = 1
    while f"S{number}" in survey.stations:
        number += 1
    station = survey.stations.add()
    station.name, station.position = f"S{number}", position_m
    survey.station_index = len(survey.stations) - 1
    return station


classes = (CableTwinStation, CableTwinSurvey)
