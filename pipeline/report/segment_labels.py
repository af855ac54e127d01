"""The sentences about a long survey's segments, in both languages, for ``pipeline.report.labels``."""

SEGMENT_TEXTS: dict[str, tuple[str, str]] = {
    "segments": ("Segments", "分段"),
    "segments_lead": (
        "The survey was worked off in {value} segments, each with a report of its own. Frames that two "
        "neighbours share and the size of the ring of cameras tie their scales to each other; the whole "
        "travel gives the scale.",
        "测量分 {value} 段处理，每段另有报告。相邻段的共有影像与相机环的尺寸联系各段尺度，"
        "全程行程给出总尺度。",
    ),
    "segments_caption": (
        "Where each segment lies, and what ties it. The joined model is straight: how the segments bend "
        "against each other is not told.",
        "各段位置及其联系。拼接后的整体模型为直线：各段之间的弯曲不予表示。",
    ),
    "segment": ("Segment", "分段"),
    "segment_from_m": ("From (m)", "起点 (m)"),
    "segment_to_m": ("To (m)", "终点 (m)"),
    "segment_frames": ("Frames", "帧数"),
    "segment_scale_ppm": ("Scale against even travel (ppm)", "相对匀速行程的尺度 (ppm)"),
    "segment_sigma_ppm": ("σ (ppm)", "σ (ppm)"),
    "segment_roll_deg": ("Robot turned by (°)", "机器人转角 (°)"),
    "segment_link_ppm": ("Contradiction to the next (ppm)", "与下一段的差异 (ppm)"),
}
