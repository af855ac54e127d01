"""What a ray meets, asked of Blender: ray casting in a bounding-volume tree over the tessellated world.

The slow second opinion on :mod:`synth.scan.panorama` (0.3 against 1.6 million rays a second on one core, and
the polygons cut inside of the true surfaces).  Needs bpy.  Run it in a process of its own::

    python -m synth.scan.blender_rays WORLD.npz  # answers into WORLD.met.npz
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.apart import keep_apart
from synth.scan.mesh import Mesh


def first_hits(mesh: Mesh, directions: Array) -> tuple[NDArray[np.int64], Array]:
    """Owners (n,) and ranges (n,) met by rays from the origin; -1 and inf where nothing is met.

    Args:
        mesh: the world in the station's frame.
        directions: (n, 3) unit vectors.
    """
    keep_apart()
    import bpy  # noqa: F401 - mathutils comes with it
    from mathutils.bvhtree import BVHTree

    tree = BVHTree.FromPolygons(mesh.vertices.tolist(), mesh.quads.tolist())
    owner, range_m = np.full(len(directions), -1, np.int64), np.full(len(directions), np.inf)
    for number, direction in enumerate(directions.tolist()):
        _, _, face, away = tree.ray_cast((0.0, 0.0, 0.0), direction)
        if face is not None:
            owner[number], range_m[number] = mesh.owner[face], away
    return owner, range_m


def main(file: Path) -> None:
    """Answer the question of a file, into the file beside it that ends in ``.met.npz``."""
    with np.load(file) as asked:
        mesh = Mesh(
            vertices=asked["vertices"], quads=asked["quads"], owner=asked["owner"], uv=np.zeros((0, 4, 2))
        )
        owner, range_m = first_hits(mesh, asked["directions"])
    np.savez(file.with_suffix(".met.npz"), owner=owner, range_m=range_m)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
