"""Small worlds for the tests."""

import numpy as np

from synth.scan.primitives import STEEL, Builder, World


def world_of(*surfaces) -> World:
    """A world of (kind, values...) surfaces, each its own owner."""
    builder = Builder()
    for number, (kind, *values) in enumerate(surfaces):
        builder.add(kind, builder.own(f"{kind}:{number}", STEEL), *(np.asarray(v, float) for v in values))
    return builder.world()
