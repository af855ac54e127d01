"""How the stages that work block by block hang together: what each is made from, so when it is made again.

Takes the survey, the options and the run folder; gives products, by block.  Holds no algorithm and no order.
"""

from pathlib import Path
from typing import Any

from pipeline.cable.adjust import Orientation, adjust_block
from pipeline.cable.crop import Crop, crop_block
from pipeline.cable.dense import RadiusMap, sweep_block
from pipeline.cable.frames import extract_frames
from pipeline.cable.lens import CableScene, LensSolution, solve_lens, undistort_frames
from pipeline.cable.match import TiePoints, match_block
from pipeline.cable.pos import pos_of_block, write_pos
from pipeline.cable.records import CableOptions, FlatFrames, SurveyFrames
from pipeline.cable.sources import image_files, is_video
from pipeline.cable.surface import BlockSurface, build_surface
from pipeline.cable.survey import Block, Survey
from pipeline.cable.texture import UnrolledPicture, texture_block
from pipeline.core.errors import StageError
from pipeline.core.events import Emit
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.store import stamp_file
from pipeline.core.vocabulary import FrameSequence, PosPriors


class BlockStages:
    """The products so far; ``made["match"][2]`` is the third block's."""

    def __init__(self, survey: Survey, options: CableOptions, folder: RunFolder, emit: Emit) -> None:
        self._survey, self._options, self._folder, self._emit = survey, options, folder, emit
        self.made: dict[str, list[Product[Any]]] = {}

    @property
    def folder(self) -> RunFolder:
        """Where products are kept."""
        return self._folder

    @property
    def emit(self) -> Emit:
        """Where progress goes."""
        return self._emit

    def _value(self, stage: str, block: int = 0) -> Any:  # noqa: ANN401 - products of every kind
        return self.made[stage][block].value

    def _needs(self, block: int, *stages: str) -> list[Product[Any]]:
        return [self.made[stage][block] for stage in stages]

    def _all(self, *stages: str) -> list[Product[Any]]:
        return [p for stage in stages for p in self.made[stage]]

    def _oriented(self, n: int) -> Product[Orientation]:
        """A block's orientation that counts: from the ring where there is one."""
        if not self.made["joint"]:
            return self.made["adjust"][n]
        joint = self.made["joint"][0]
        return Product(joint.value.blocks[n], f"{joint.stamp}/{n}")

    def _frames(self) -> list[Product[Any]]:
        survey = self._survey
        sources = [[stamp_file(f) for f in _source_files(b)] for b in survey.blocks]
        places = [(b.name, b.travel_in_image, b.lens_spec) for b in survey.blocks]
        unordered = [b.name for b in survey.blocks if not b.ordered]
        rough = (unordered, survey.robot.standoff_m, survey.cable.diameter_mm) if unordered else None
        product = self._folder.product(
            "frames",
            SurveyFrames,
            lambda: SurveyFrames(
                sequences=extract_frames(
                    survey, self._options.frames, self._folder.path / "blocks", self._emit
                )
            ),
            sources,
            places,
            survey.cable.travel_m,
            survey.robot.synchronised,
            self._options.frames,
            rough,
        )
        return [
            Product.of(sequence, source, root=self._folder.root)
            for sequence, source in zip(product.value.sequences, sources, strict=True)
        ]

    def _lens(self, n: int, block: Block, emit: Emit) -> Product[LensSolution]:
        frames: FrameSequence = self._value("frames", n)
        cable, robot = self._survey.cable, self._survey.robot
        spec, options = block.lens_spec, self._options.lens
        nominal = None if cable.diameter_mm is None else cable.diameter_mm / 1000
        scene = CableScene(travel_m=cable.travel_m, standoff_m=robot.standoff_m, diameter_m=nominal)

        def make() -> LensSolution:
            return solve_lens(
                frames,
                block.lens(frames.width_px, frames.height_px),
                spec.division_lambda is not None,
                block.travel_in_image,
                options,
                emit,
                scene=scene,
            )

        needs = [*self._needs(n, "frames"), spec, block.travel_in_image, scene, options]
        return self._folder.product("lens", LensSolution, make, *needs, block=block.name)

    def _pos(self, n: int, block: Block, _: Emit) -> Product[PosPriors]:
        survey, options = self._survey, self._options.pos
        frames: FrameSequence = self._value("frames", n)

        def make() -> PosPriors:
            pos = pos_of_block(survey, block, frames, options)
            write_pos(self._folder.block(block.name) / "pos.csv", block, frames, pos)
            return pos

        measured = stamp_file(block.pos) if block.pos else None
        cable, standoff_m = survey.cable, survey.robot.standoff_m
        place = (block.angle_deg, block.travel_in_image, standoff_m, cable.travel_m, cable.travel_sigma_mm)
        needs = [*self._needs(n, "frames"), measured, place, options]
        return self._folder.product("pos", PosPriors, make, *needs, block=block.name)

    def _match(self, n: int, block: Block, emit: Emit) -> Product[TiePoints]:
        lens: LensSolution = self._value("lens", n)
        radius_m = self._rough_radius_m(lens)
        needs = [*self._needs(n, "lens", "pos"), block.angle_deg, radius_m, self._options.match]
        return self._folder.product(
            "match",
            TiePoints,
            lambda: match_block(
                self._value("frames", n),
                lens.lens,
                self._value("pos", n),
                block.angle_deg,
                radius_m,
                self._options.match,
                emit,
            ),
            *needs,
            block=block.name,
        )

    def _rough_radius_m(self, lens: LensSolution) -> float:
        nominal = self._survey.cable.diameter_mm
        radius_m = nominal / 2000 if nominal else lens.apparent_radius_m
        if not radius_m > 0:
            raise StageError(
                "match",
                "the cable's rough diameter is not known, for its outline was not found",
                "give cable.diameter_mm in survey.toml",
            )
        return radius_m

    def _adjust(self, n: int, block: Block, emit: Emit) -> Product[Orientation]:
        lens: LensSolution = self._value("lens", n)
        return self._folder.product(
            "adjust",
            Orientation,
            lambda: adjust_block(
                block.name,
                self._value("match", n),
                lens.lens,
                self._value("pos", n),
                self._options.adjust,
                emit,
            ),
            *self._needs(n, "match", "lens", "pos"),
            self._options.adjust,
            block=block.name,
        )

    def _undistort(self, n: int, block: Block, emit: Emit) -> Product[FlatFrames]:
        frames: FrameSequence = self._value("frames", n)
        lens = self._oriented(n).value.lens

        def make() -> FlatFrames:
            folder = self._folder.block(block.name) / "undistorted"
            flat, pinhole = undistort_frames(frames, lens, folder, emit)
            return FlatFrames(frames=flat, pinhole=pinhole)

        needs = [*self._needs(n, "frames"), lens]
        return self._folder.product("undistort", FlatFrames, make, *needs, block=block.name)

    def _dense(self, n: int, block: Block, emit: Emit) -> Product[RadiusMap]:
        return self._folder.product(
            "dense",
            RadiusMap,
            lambda: sweep_block(
                self._value("frames", n),
                self._oriented(n).value,
                block.angle_deg,
                self._options.dense,
                emit,
                self._folder.block(block.name) / "patch_match",
            ),
            *self._needs(n, "frames"),
            self._oriented(n),
            block.angle_deg,
            self._options.dense,
            block=block.name,
        )

    def _surface(self, n: int, block: Block, _: Emit) -> Product[BlockSurface]:
        return self._folder.product(
            "surface",
            BlockSurface,
            lambda: build_surface(self._value("dense", n), self._options.surface),
            *self._needs(n, "dense"),
            self._options.surface,
            block=block.name,
        )

    def _texture(self, n: int, block: Block, emit: Emit) -> Product[UnrolledPicture]:
        dense: RadiusMap = self._value("dense", n)
        return self._folder.product(
            "texture",
            UnrolledPicture,
            lambda: texture_block(
                self._value("frames", n),
                self._oriented(n).value,
                self._value("surface", n),
                dense.ground_sample_mm,
                self._options.texture,
                emit,
            ),
            *self._needs(n, "frames", "surface"),
            self._oriented(n),
            self._options.texture,
            block=block.name,
        )

    def _crop(self, n: int, block: Block, _: Emit) -> Product[Crop]:
        standoff_m = self._survey.robot.standoff_m
        return self._folder.product(
            "crop",
            Crop,
            lambda: crop_block(
                block.name, self._value("surface", n), block.angle_deg, standoff_m, self._options.crop
            ),
            *self._needs(n, "surface"),
            block.angle_deg,
            standoff_m,
            self._options.crop,
            block=block.name,
        )


def _source_files(block: Block) -> tuple[Path, ...]:
    return (block.source,) if is_video(block) else image_files(block)
