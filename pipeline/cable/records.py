"""What goes into a run and what comes out: the options of every stage, and everything that was found."""

from dataclasses import dataclass, field

from pipeline.cable.adjust import AdjustOptions, Orientation
from pipeline.cable.closing import ClosingOptions
from pipeline.cable.crop import Crop, CropOptions
from pipeline.cable.dense import DenseOptions, RadiusMap
from pipeline.cable.frames import FrameOptions
from pipeline.cable.joint import JointOptions, RingOrientation
from pipeline.cable.lens import LensOptions, LensSolution
from pipeline.cable.match import MatchOptions, TiePoints
from pipeline.cable.measure import Measurement, MeasureOptions
from pipeline.cable.mosaic import Mosaic, MosaicOptions
from pipeline.cable.pos import PosOptions
from pipeline.cable.relief import ReliefOptions
from pipeline.cable.ring import Ring, RingOptions
from pipeline.cable.surface import BlockSurface, SurfaceOptions
from pipeline.cable.survey import Block, Survey
from pipeline.cable.texture import TextureOptions, UnrolledPicture
from pipeline.core.vocabulary import FrameSequence, Lens, PosPriors
from pipeline.segments.plan import SegmentOptions


@dataclass(frozen=True, kw_only=True)
class CableOptions:
    """The options of every stage; ``[options.STAGE]`` in survey.toml, ``--set STAGE.key=value``."""

    frames: FrameOptions = field(default_factory=FrameOptions)
    lens: LensOptions = field(default_factory=LensOptions)
    pos: PosOptions = field(default_factory=PosOptions)
    match: MatchOptions = field(default_factory=MatchOptions)
    adjust: AdjustOptions = field(default_factory=AdjustOptions)
    closing: ClosingOptions = field(default_factory=ClosingOptions)
    joint: JointOptions = field(default_factory=JointOptions)
    dense: DenseOptions = field(default_factory=DenseOptions)
    surface: SurfaceOptions = field(default_factory=SurfaceOptions)
    texture: TextureOptions = field(default_factory=TextureOptions)
    crop: CropOptions = field(default_factory=CropOptions)
    mosaic: MosaicOptions = field(default_factory=MosaicOptions)
    ring: RingOptions = field(default_factory=RingOptions)
    measure: MeasureOptions = field(default_factory=MeasureOptions)
    relief: ReliefOptions = field(default_factory=ReliefOptions)
    segments: SegmentOptions = field(default_factory=SegmentOptions)


@dataclass(frozen=True, kw_only=True)
class SurveyFrames:
    """The frames of all blocks."""

    sequences: tuple[FrameSequence, ...]


@dataclass(frozen=True, kw_only=True)
class FlatFrames:
    """A block's frames as a pinhole camera would have taken them, and that camera.

    Nothing is measured in them: they are for people and for other programs.
    """

    frames: FrameSequence
    pinhole: Lens


@dataclass(frozen=True, kw_only=True)
class BlockRun:
    """Everything the pipeline found about one block."""

    block: Block
    frames: FrameSequence
    lens: LensSolution
    pos: PosPriors
    tie_points: TiePoints
    orientation: Orientation
    dense: RadiusMap
    surface: BlockSurface
    picture: UnrolledPicture
    crop: Crop


@dataclass(frozen=True, kw_only=True)
class CableRun:
    """Everything the pipeline found; ``together`` is None where the blocks were adjusted alone.

    ``cautions`` are sentences about what looks wrong though it could be worked with.
    """

    survey: Survey
    options: CableOptions
    blocks: tuple[BlockRun, ...]
    together: RingOrientation | None
    mosaic: Mosaic
    ring: Ring
    measurement: Measurement
    cautions: tuple[str, ...] = ()
