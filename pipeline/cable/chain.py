"""How the stages hang together: for each, what it is made from, and so when it must be made again.

Takes the survey, the options and the run folder; gives the products.  Holds no algorithm and no order.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.cable.adjust import Orientation, adjust_block
from pipeline.cable.closing import ClosingBlock, SharedMarks, find_shared_marks
from pipeline.cable.crop import Crop, crop_block
from pipeline.cable.dense import RadiusMap, sweep_block
from pipeline.cable.frames import extract_frames
from pipeline.cable.joint import JointBlock, RingOrientation, adjust_ring
from pipeline.cable.lens import CableScene, LensSolution, solve_lens, undistort_frames
from pipeline.cable.match import TiePoints, match_block
from pipeline.cable.measure import Measurement, measure_ring
from pipeline.cable.mosaic import Mosaic, MosaicBlock, PointPairs, mosaic_blocks
from pipeline.cable.pairs import check_pairs, read_pairs
from pipeline.cable.pos import pos_of_block, robot_priors, travel_share_sigma, write_pos
from pipeline.cable.records import BlockLens, BlockRun, CableOptions, CableRun, SurveyFrames
from pipeline.cable.ring import Ring, build_ring
from pipeline.cable.sources import image_files, is_video
from pipeline.cable.surface import BlockSurface, build_surface
from pipeline.cable.survey import Block, Survey
from pipeline.cable.texture import UnrolledPicture, texture_block
from pipeline.cable.uncertainty import RingSigmas, Uncertainty
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.store import stamp_file
from pipeline.core.vocabulary import FrameSequence, Lens, PosPriors

type _PerBlock = Callable[[int, Block], Product[Any]]


class Chain:
    """The products so far; ``made["match"][2]`` is the third block's, ``made["mosaic"][0]`` the only one."""

    def __init__(self, survey: Survey, options: CableOptions, folder: RunFolder, emit: Emit) -> None:
        self._survey, self._options, self._folder, self._emit = survey, options, folder, emit
        self.made: dict[str, list[Product[Any]]] = {}

    def run(self, name: str, pairs: Path | None) -> None:
        """Make one stage's products, of every block where it works block by block."""
        if name == "frames":
            self.made[name] = self._frames()
        elif name == "mosaic":
            self.made[name] = [self._mosaic(pairs)]
        elif name in ("closing", "joint"):
            self.made[name] = [getattr(self, f"_{name}")()] if self._together() else []
        elif name in ("ring", "measure"):
            self.made[name] = [getattr(self, f"_{name}")()]
        else:
            stage: _PerBlock = getattr(self, f"_{name}")
            self.made[name] = [stage(n, b) for n, b in enumerate(self._survey.blocks)]
        self._emit(Event(stage=name, done=1, total=1))

    def result(self) -> CableRun:
        """Everything found, from the finished products."""
        return CableRun(
            survey=self._survey,
            options=self._options,
            blocks=tuple(
                BlockRun(
                    block=block,
                    frames=self._value("frames", n),
                    lens=self._value("lens", n),
                    pos=self._value("pos", n),
                    tie_points=self._value("match", n),
                    orientation=self._oriented(n).value,
                    dense=self._value("dense", n),
                    surface=self._value("surface", n),
                    picture=self._value("texture", n),
                    crop=self._value("crop", n),
                )
                for n, block in enumerate(self._survey.blocks)
            ),
            together=self._value("joint") if self.made["joint"] else None,
            mosaic=self._value("mosaic"),
            ring=self._value("ring"),
            measurement=self._value("measure"),
        )

    def _value(self, stage: str, block: int = 0) -> Any:  # noqa: ANN401 - products of every kind
        return self.made[stage][block].value

    def _needs(self, block: int, *stages: str) -> list[Product[Any]]:
        return [self.made[stage][block] for stage in stages]

    def _frames(self) -> list[Product[Any]]:
        survey = self._survey
        sources = [[stamp_file(f) for f in _source_files(b)] for b in survey.blocks]
        places = [(b.name, b.travel_in_image, b.lens_spec) for b in survey.blocks]
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
        )
        return [
            Product.of(sequence, source, root=self._folder.path)
            for sequence, source in zip(product.value.sequences, sources, strict=True)
        ]

    def _lens(self, n: int, block: Block) -> Product[BlockLens]:
        frames: FrameSequence = self._value("frames", n)
        cable, robot = self._survey.cable, self._survey.robot
        spec, options = block.lens_spec, self._options.lens
        nominal = None if cable.diameter_mm is None else cable.diameter_mm / 1000
        scene = CableScene(travel_m=cable.travel_m, standoff_m=robot.standoff_m, diameter_m=nominal)

        def make() -> BlockLens:
            solution = solve_lens(
                frames,
                block.lens(frames.width_px, frames.height_px),
                spec.division_lambda is not None,
                block.travel_in_image,
                options,
                part(self._emit, 0.0, 0.3),
                scene=scene,
            )
            folder = self._folder.block(block.name) / "undistorted"
            undistorted, pinhole = undistort_frames(frames, solution.lens, folder, part(self._emit, 0.3, 1.0))
            return BlockLens(solution=solution, undistorted=undistorted, pinhole=pinhole)

        needs = [*self._needs(n, "frames"), spec, block.travel_in_image, scene, options]
        return self._folder.product("lens", BlockLens, make, *needs, block=block.name)

    def _pos(self, n: int, block: Block) -> Product[PosPriors]:
        survey, options = self._survey, self._options.pos
        frames: FrameSequence = self._value("frames", n)

        def make() -> PosPriors:
            pos = pos_of_block(survey, block, frames, options)
            write_pos(self._folder.block(block.name) / "pos.csv", block, frames, pos)
            return pos

        measured = stamp_file(block.pos) if block.pos else None
        place = (block.angle_deg, block.travel_in_image, survey.robot.standoff_m, survey.cable.travel_m)
        needs = [*self._needs(n, "frames"), measured, place, options]
        return self._folder.product("pos", PosPriors, make, *needs, block=block.name)

    def _match(self, n: int, block: Block) -> Product[TiePoints]:
        lens: BlockLens = self._value("lens", n)
        radius_m = self._rough_radius_m(lens.solution)
        needs = [*self._needs(n, "lens", "pos"), block.angle_deg, radius_m, self._options.match]
        return self._folder.product(
            "match",
            TiePoints,
            lambda: match_block(
                self._value("frames", n),
                lens.solution.lens,
                self._value("pos", n),
                block.angle_deg,
                radius_m,
                self._options.match,
                self._emit,
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

    def _adjust(self, n: int, block: Block) -> Product[Orientation]:
        lens: BlockLens = self._value("lens", n)
        return self._folder.product(
            "adjust",
            Orientation,
            lambda: adjust_block(
                block.name,
                self._value("match", n),
                lens.solution.lens,
                self._value("pos", n),
                self._options.adjust,
                self._emit,
            ),
            *self._needs(n, "match", "lens", "pos"),
            self._options.adjust,
            block=block.name,
        )

    def _together(self) -> bool:
        """Whether the cameras are adjusted as one rig: one clock, and no POS that says otherwise."""
        survey = self._survey
        return (
            self._options.joint.together
            and survey.robot.synchronised
            and len(survey.blocks) > 1
            and all(b.pos is None for b in survey.blocks)
        )

    def _closing(self) -> Product[SharedMarks]:
        def make() -> SharedMarks:
            blocks = tuple(
                ClosingBlock(
                    frames=self._value("frames", n),
                    orientation=self._value("adjust", n),
                    azimuth_deg=block.angle_deg,
                )
                for n, block in enumerate(self._survey.blocks)
            )
            return find_shared_marks(blocks, self._options.closing, self._emit)

        angles = [b.angle_deg for b in self._survey.blocks]
        needs = [*self._all("frames", "adjust"), angles, self._options.closing]
        return self._folder.product("closing", SharedMarks, make, *needs)

    def _joint(self) -> Product[RingOrientation]:
        survey = self._survey
        frames: FrameSequence = self._value("frames", 0)
        robot = robot_priors(survey.robot, survey.cable, frames, self._options.pos)

        def make() -> RingOrientation:
            blocks = tuple(
                JointBlock(
                    name=block.name,
                    azimuth_deg=block.angle_deg,
                    travel_in_image=block.travel_in_image,
                    orientation=self._value("adjust", n),
                )
                for n, block in enumerate(survey.blocks)
            )
            return adjust_ring(blocks, self._value("closing"), robot, self._options.joint, self._emit)

        places = [(b.angle_deg, b.travel_in_image) for b in survey.blocks]
        needs = [*self._all("adjust", "closing"), robot, places, self._options.joint]
        return self._folder.product("joint", RingOrientation, make, *needs)

    def _oriented(self, n: int) -> Product[Orientation]:
        """A block's orientation that counts: from the ring where there is one."""
        if not self.made["joint"]:
            return self.made["adjust"][n]
        joint = self.made["joint"][0]
        return Product(joint.value.blocks[n], f"{joint.stamp}/{n}")

    def _dense(self, n: int, block: Block) -> Product[RadiusMap]:
        return self._folder.product(
            "dense",
            RadiusMap,
            lambda: sweep_block(
                self._value("frames", n),
                self._oriented(n).value,
                block.angle_deg,
                self._options.dense,
                self._emit,
                self._folder.block(block.name) / "patch_match",
            ),
            *self._needs(n, "frames"),
            self._oriented(n),
            block.angle_deg,
            self._options.dense,
            block=block.name,
        )

    def _surface(self, n: int, block: Block) -> Product[BlockSurface]:
        return self._folder.product(
            "surface",
            BlockSurface,
            lambda: build_surface(self._value("dense", n), self._options.surface),
            *self._needs(n, "dense"),
            self._options.surface,
            block=block.name,
        )

    def _texture(self, n: int, block: Block) -> Product[UnrolledPicture]:
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
                self._emit,
            ),
            *self._needs(n, "frames", "surface"),
            self._oriented(n),
            self._options.texture,
            block=block.name,
        )

    def _crop(self, n: int, block: Block) -> Product[Crop]:
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

    def _joined(self) -> tuple[MosaicBlock, ...]:
        return tuple(
            MosaicBlock(
                name=block.name,
                surface=self._value("surface", n),
                keep=self._value("crop", n).keep,
                picture=self._value("texture", n),
                datum_origin=self._oriented(n).value.datum_origin,
                datum_information=self._oriented(n).value.datum_information,
            )
            for n, block in enumerate(self._survey.blocks)
        )

    def _all(self, *stages: str) -> list[Product[Any]]:
        return [p for stage in stages for p in self.made[stage]]

    def _mosaic(self, pairs: Path | None) -> Product[Mosaic]:
        names = tuple(b.name for b in self._survey.blocks)

        def make() -> Mosaic:
            given: tuple[PointPairs, ...] | None = None
            if pairs:
                given = read_pairs(pairs, names)
                check_pairs(pairs, given, self._joined())
            settled = self._value("joint").covariance if self.made["joint"] else None
            return mosaic_blocks(self._joined(), given, settled, self._options.mosaic, self._emit)

        needs = [
            *self._all("surface", "crop", "texture", "adjust", "joint"),
            stamp_file(pairs) if pairs else None,
            self._options.mosaic,
        ]
        return self._folder.product("mosaic", Mosaic, make, *needs)

    def _ring(self) -> Product[Ring]:
        return self._folder.product(
            "ring",
            Ring,
            lambda: build_ring(
                self._joined(),
                tuple(p.value for p in self.made["crop"]),
                self._value("mosaic"),
                self._survey.cable.travel_m,
                self._options.ring,
                self._emit,
            ),
            *self._all("surface", "crop", "texture", "mosaic"),
            self._survey.cable.travel_m,
            self._options.ring,
        )

    def _measure(self) -> Product[Measurement]:
        survey = self._survey
        stations = tuple((s.name, s.position_m) for s in survey.cable.stations)
        uncertainty = self._uncertainty()
        return self._folder.product(
            "measure",
            Measurement,
            lambda: measure_ring(
                self._joined(),
                tuple(p.value for p in self.made["crop"]),
                self._value("mosaic"),
                self._value("ring"),
                uncertainty,
                stations,
                survey.cable.travel_m,
                self._options.measure,
                self._emit,
            ),
            *self._all("surface", "crop", "mosaic", "ring"),
            uncertainty,
            stations,
            survey.cable.travel_m,
            self._options.measure,
        )

    def _uncertainty(self) -> Uncertainty:
        lenses: list[Lens] = [self._oriented(n).value.lens for n in range(len(self._survey.blocks))]
        ring: RingOrientation | None = self._value("joint") if self.made["joint"] else None
        return Uncertainty(
            noise_mm=tuple(p.value.noise_mm for p in self.made["dense"]),
            focal_shares=tuple(lens.focal_sigma_px / lens.focal_px for lens in lenses),
            travel_share=travel_share_sigma(self._survey.cable, self._options.pos),
            together=None
            if ring is None
            else RingSigmas(
                y_m=ring.section_y_m, diameter_mm=ring.diameter_sigma_mm, lens_mm=ring.lens_sigma_mm
            ),
        )


def _source_files(block: Block) -> tuple[Path, ...]:
    return (block.source,) if is_video(block) else image_files(block)
