"""Catalogues of the library, and what an asset tells of itself in the Asset Browser.

The UUIDs are for ever: files of people refer to them.
"""

from dataclasses import dataclass
from pathlib import Path

import bpy

AUTHOR = "CableTwin contributors"
LICENCE = "GPL-3.0-or-later"
FILE = "blender_assets.cats.txt"


@dataclass(frozen=True, kw_only=True)
class Catalogue:
    """One catalogue.

    Attributes:
        uuid: stable.
        path: as the Asset Browser nests it.
    """

    uuid: str
    path: str


CABLES = Catalogue(uuid="6c6b1a0e-52b1-4a3f-9f0b-7d1f5a3c9e01", path="CableTwin/Cables")
SHEATHS = Catalogue(uuid="b4a9d0c7-0d5e-4e6f-8a55-2f6c1e8b7d02", path="CableTwin/Sheaths")
ROBOTS = Catalogue(uuid="e17f38d2-9c44-4b8a-a6d3-58c0b92f4a03", path="CableTwin/Robots")
CATALOGUES = (CABLES, ROBOTS, SHEATHS)


def mark(item: bpy.types.ID, catalogue: Catalogue, description: str, tags: tuple[str, ...]) -> None:
    """Make a datablock an asset."""
    item.asset_mark()
    told = item.asset_data
    told.catalog_id = catalogue.uuid
    told.description, told.author, told.license = description, AUTHOR, LICENCE
    for tag in tags:
        told.tags.new(tag, skip_if_exists=True)


def write_catalogues(folder: Path) -> Path:
    """Write the catalogue file at the library's root."""
    lines = ["# CableTwin's asset library, written by blend_assets/build.py", "VERSION 1", ""]
    lines += [f"{c.uuid}:{c.path}:{c.path.replace('/', '-')}" for c in CATALOGUES]
    path = folder / FILE
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return path
