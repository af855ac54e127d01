"""Properties that a survey and a synthetic one both have, said once.

Each takes the function that follows a change, or None; gives a property for a group's annotations.
"""

from collections.abc import Callable

import bpy

type Follow = Callable[[bpy.types.PropertyGroup, bpy.types.Context], None] | None


def travel_in_image(follow: Follow) -> object:
    """Where the travel points in the picture."""
    return bpy.props.EnumProperty(
        name="Travel in image",
        description="Direction of the image in which the robot's travel points",
        items=(
            ("right", "Right", "The robot travels towards the right edge"),
            ("left", "Left", "The robot travels towards the left edge"),
            ("up", "Up", "The robot travels towards the upper edge"),
            ("down", "Down", "The robot travels towards the lower edge"),
        ),
        update=follow,
    )


def standoff(follow: Follow) -> object:
    """Metres, shown in the scene's unit."""
    return bpy.props.FloatProperty(
        name="Stand-off",
        description="From the centre of a camera to the axis of the cable",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.3,
        min=0.001,
        precision=4,
        update=follow,
    )


def cameras(follow: Follow) -> object:
    """How many there are in the ring."""
    return bpy.props.IntProperty(
        name="Cameras",
        description="Cameras around the cable, at equal angles",
        default=4,
        min=1,
        max=16,
        update=follow,
    )


def synchronised() -> object:
    """Whether the cameras share one clock."""
    return bpy.props.BoolProperty(
        name="Synchronised",
        description="All cameras share one clock and one motion: frame k of each is one moment",
        default=True,
    )


def focal_px(follow: Follow) -> object:
    """Pixels."""
    return bpy.props.FloatProperty(
        name="Focal length", description="In pixels", default=720, min=1, precision=2, update=follow
    )


def division_lambda(usual: float, follow: Follow) -> object:
    """Without a unit: :func:`lambda_radius` says what its radius is measured in."""
    return bpy.props.FloatProperty(
        name="Lambda",
        description="Distortion of the division model; negative is barrel",
        default=usual,
        soft_min=-0.25,
        soft_max=0.25,
        precision=5,
        step=0.1,
        update=follow,
    )


def lambda_radius(follow: Follow) -> object:
    """As survey.toml names them."""
    return bpy.props.EnumProperty(
        name="Radius in",
        description="What the radius of lambda is measured in",
        items=(
            ("half-diagonal", "Half diagonal", "Of the image"),
            ("half-width", "Half width", "Of the image"),
            ("focal", "Focal length", "The focal length"),
            ("pixel", "Pixels", "A pixel"),
        ),
        update=follow,
    )
