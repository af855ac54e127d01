"""The section on the segments of a long survey: a table with a link to each segment's own report.

Takes :class:`~pipeline.report.segment_records.SegmentSummary` records, gives HTML.
"""

from pipeline.report.markup import Row, Writer, escaped, number, signed
from pipeline.report.segment_records import SegmentSummary

_COLUMNS = (
    *("segment", "segment_from_m", "segment_to_m", "segment_frames", "segment_scale_ppm"),
    *("segment_sigma_ppm", "segment_roll_deg", "segment_link_ppm", "segment_bend_x", "segment_bend_z"),
    "segment_bend_sigma",
)


def segment_section(writer: Writer, segments: tuple[SegmentSummary, ...]) -> str:
    """The whole section, or "" where the survey was worked off in one piece."""
    if not segments:
        return ""
    heads = [writer.say(key, "th", 'scope="col"') for key in _COLUMNS]
    lead = writer.say("segments_lead", "p", 'class="lead"', value=str(len(segments)))
    table = writer.table(
        writer.say("segments_caption", "figcaption"), heads, [_row(segment) for segment in segments]
    )
    return lead + table


def _row(segment: SegmentSummary) -> Row:
    name = escaped(segment.name)
    return Row(
        head=f'<th scope="row"><a href="segments/{name}/report.html">{name}</a></th>',
        cells=[
            number(segment.from_m, 3),
            number(segment.to_m, 3),
            str(segment.frames),
            signed(1e6 * (segment.scale - 1), 0),
            number(1e6 * segment.scale_sigma, 0),
            signed(segment.roll_deg, 2),
            signed(segment.link_ppm, 0),
            *(signed(lean, 2) for lean in segment.bend_mm_per_m),
            number(segment.bend_sigma_mm_per_m, 2),
        ],
    )
