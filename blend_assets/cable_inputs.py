"""What the cable's modifier asks for: the cable part of SPEC.toml as inputs, in the order of its shape."""

from blend_assets.inputs import Input, Panel, degrees

STATIONS = ("A", "B", "C", "D")
DEFECTS = ("Defect 1", "Defect 2")
_PLACES_M = (0.10, 0.19, 0.28, 0.37)
_DIAMETERS_MM = (111.4, 110.8, 110.7, 111.1)  # the paper's

_ROUND_INPUTS = (
    Input(name="Travel", kind="length", default=0.46, low=0.001, description="Path of the robot, from y = 0"),
    Input(
        name="Margin",
        kind="length",
        default=0.3,
        low=0.001,
        description="Cable before the first and behind the last position of the robot",
    ),
    Input(
        name="Diameter (mm)",
        kind="number",
        default=110.0,
        low=1.0,
        description="Mean diameter, where no station sets one",
    ),
    Input(
        name="Ovality (mm)",
        kind="number",
        default=0.0,
        low=0.0,
        description="Largest minus smallest diameter of the elliptic section",
    ),
    Input(name="Ovality angle", kind="angle", default=0.0, description="Azimuth of the largest diameter"),
)

_STATION_INPUTS = (
    Input(
        name="Stations",
        kind="count",
        default=0,
        low=0,
        high=len(STATIONS),
        description="Stations in use, in the order of their positions",
    ),
    Input(
        name="Own diameters",
        kind="switch",
        default=True,
        description="The stations set the diameter, with smooth transitions between them",
    ),
    *(
        row
        for name, place_m, diameter_mm in zip(STATIONS, _PLACES_M, _DIAMETERS_MM, strict=True)
        for row in (
            Input(
                name=f"{name} position",
                kind="length",
                default=place_m,
                low=0.0,
                description="Along the axis from the first frame",
            ),
            Input(
                name=f"{name} diameter (mm)",
                kind="number",
                default=diameter_mm,
                low=1.0,
                description="Mean diameter at this station",
            ),
        )
    ),
)

_FILLET_INPUTS = (
    Input(name="Height (mm)", kind="number", default=2.0, low=0.01, description="Crest over the sheath"),
    Input(name="Width (mm)", kind="number", default=8.0, low=0.1, description="Of a rib, around the girth"),
    Input(name="Pitch", kind="length", default=0.6, low=0.01, description="Length of one turn"),
    Input(name="Angle", kind="angle", default=degrees(30), description="Azimuth of the first rib at y = 0"),
)

_BOW_INPUTS = (
    Input(
        name="Bow (mm)",
        kind="number",
        default=0.0,
        low=0.0,
        description="Rise of the axis' parabola half-way of the travel",
    ),
    Input(name="Bow azimuth", kind="angle", default=degrees(90), description="Direction of that rise"),
)


def _defect_inputs(place_m: float, azimuth_deg: float, height_mm: float) -> tuple[Input, ...]:
    return (
        Input(
            name="Height (mm)",
            kind="number",
            default=height_mm,
            description="Of the middle over the sheath: positive is a bulge, negative a dent",
        ),
        Input(name="Position", kind="length", default=place_m, low=0.0, description="Middle, along the axis"),
        Input(name="Azimuth", kind="angle", default=degrees(azimuth_deg), description="Of the middle"),
        Input(name="Length (mm)", kind="number", default=40.0, low=1.0, description="Along the cable"),
        Input(name="Width (mm)", kind="number", default=40.0, low=1.0, description="Around the girth"),
    )


_MESH_INPUTS = (
    Input(
        name="Columns",
        kind="count",
        default=360,
        low=12,
        high=4000,
        description="Faces around the girth; with ribs two fifths of them lie across the ribs",
    ),
    Input(
        name="Row spacing (mm)",
        kind="number",
        default=1.5,
        low=0.1,
        description="Distance of the rows along the axis",
    ),
)

CABLE = (
    Panel(name="", description="", inputs=_ROUND_INPUTS),
    Panel(name="Stations", description="Where the diameter is set and asked for", inputs=_STATION_INPUTS),
    Panel(name="Bow", description="The cable is not straight", inputs=_BOW_INPUTS),
    Panel(
        name="Fillet",
        description="Two helical ribs half a turn apart, right-handed along the travel",
        inputs=_FILLET_INPUTS,
        switch=True,
    ),
    Panel(
        name=DEFECTS[0],
        description="A smooth bulge or dent",
        inputs=_defect_inputs(0.15, 45.0, 1.5),
        switch=True,
    ),
    Panel(
        name=DEFECTS[1],
        description="Another smooth bulge or dent",
        inputs=_defect_inputs(0.3, 135.0, -1.0),
        switch=True,
    ),
    Panel(name="Mesh", description="How fine the surface is", inputs=_MESH_INPUTS),
)
