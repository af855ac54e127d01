"""State of the area *mosaic*: pairs of corresponding points, and how well the blocks fit."""

import bpy


class CableTwinPair(bpy.types.PropertyGroup):
    """The same mark on two blocks, in metres as each block stands by itself."""

    block_a: bpy.props.StringProperty(name="First block", description="Block of the first point")
    block_b: bpy.props.StringProperty(name="Second block", description="Block of the second point")
    point_a: bpy.props.FloatVectorProperty(
        name="First point",
        description="Mark on the first block, in its own frame",
        subtype="XYZ",
        precision=5,
    )
    point_b: bpy.props.FloatVectorProperty(
        name="Second point",
        description="The same mark on the second block, in its own frame",
        subtype="XYZ",
        precision=5,
    )
    adjustment_a: bpy.props.StringProperty(description="Stamp of the first block's adjustment when picked")
    adjustment_b: bpy.props.StringProperty(description="Stamp of the second block's adjustment when picked")
    residual_mm: bpy.props.FloatProperty(
        name="Residual", description="Distance of the two points as the blocks stand now, millimetres"
    )
    found: bpy.props.BoolProperty(name="Found", description="Found automatically to close the ring")


class CableTwinJoin(bpy.types.PropertyGroup):
    """How two blocks fit: root mean squares in millimetres."""

    block_a: bpy.props.StringProperty()
    block_b: bpy.props.StringProperty()
    pairs: bpy.props.IntProperty()
    points_mm: bpy.props.FloatProperty()
    surface_mm: bpy.props.FloatProperty()


class CableTwinMosaic(bpy.types.PropertyGroup):
    """Pairs, and the blocks between which they are picked."""

    way: bpy.props.EnumProperty(
        name="Join",
        description="Where the corresponding points come from",
        items=(
            ("AUTOMATIC", "Automatic", "Found in the blocks' pictures"),
            ("BY_HAND", "By hand", "The pairs below; the first of each two blocks is held together"),
        ),
    )
    pairs: bpy.props.CollectionProperty(type=CableTwinPair)
    pair_index: bpy.props.IntProperty(name="Pair", description="The pair that is chosen")
    block_a: bpy.props.StringProperty(
        name="First block", description="Where the first point is picked; empty takes any block"
    )
    block_b: bpy.props.StringProperty(
        name="Second block", description="Where the second point is picked; empty takes any other block"
    )
    joins: bpy.props.CollectionProperty(type=CableTwinJoin)

    def pair(self) -> CableTwinPair | None:
        """The chosen pair, or None."""
        return self.pairs[self.pair_index] if 0 <= self.pair_index < len(self.pairs) else None

    def held(self) -> list[bool]:
        """For each pair whether it is the one that is held together: the first of its two blocks."""
        seen: set[frozenset[str]] = set()
        found = []
        for pair in self.pairs:
            blocks = frozenset((pair.block_a, pair.block_b))
            found.append(blocks not in seen)
            seen.add(blocks)
        return found


classes = (CableTwinPair, CableTwinJoin, CableTwinMosaic)
