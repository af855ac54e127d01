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
        "Where each segment lies, what ties it, and by how much the next one leans out of its axis. The "
        "joined model is laid straight along its axis; how the axis bends is told by the plot of the axis.",
        "各段位置、联系以及下一段相对其轴线的倾斜。整体模型沿轴线展直；轴线的弯曲见轴线图。",
    ),
    "segment": ("Segment", "分段"),
    "segment_from_m": ("From (m)", "起点 (m)"),
    "segment_to_m": ("To (m)", "终点 (m)"),
    "segment_frames": ("Frames", "帧数"),
    "segment_scale_ppm": ("Scale against even travel (ppm)", "相对匀速行程的尺度 (ppm)"),
    "segment_sigma_ppm": ("σ (ppm)", "σ (ppm)"),
    "segment_roll_deg": ("Robot turned by (°)", "机器人转角 (°)"),
    "segment_link_ppm": ("Contradiction to the next (ppm)", "与下一段的差异 (ppm)"),
    "segment_bend_x": ("Next leans towards x (mm/m)", "下一段向 x 倾斜 (mm/m)"),
    "segment_bend_z": ("Towards z (mm/m)", "向 z 倾斜 (mm/m)"),
    "segment_bend_sigma": ("σ of the lean (mm/m)", "倾斜的 σ (mm/m)"),
}
