"""The sentences of the page about a scan of a cable, in both languages, for ``pipeline.report.labels``."""

SCAN_TEXTS: dict[str, tuple[str, str]] = {
    "scan_title": ("Laser scan and photo model", "激光扫描与影像模型"),
    "scan_subtitle": (
        "A laser scan of the cable in the frame of its photo model, and how the two differ",
        "将缆索激光扫描归算到影像模型坐标系，并比较两者差异",
    ),
    "scan_points": ("{value} scanned points on the cable", "缆索上 {value} 个扫描点"),
    "scan_card_scale": ("Scale", "比例"),
    "scan_card_scale_note": ("scan over model, σ {value} %", "扫描 / 模型，σ {value} %"),
    "scan_card_mean": ("Mean deviation", "平均偏差"),
    "scan_card_mean_note": ("scan − model, outward", "扫描 − 模型，向外为正"),
    "scan_card_rms": ("RMS of points", "点偏差均方根"),
    "scan_card_rms_note": ("with the scanner's noise, {value} mm", "含扫描噪声 {value} mm"),
    "scan_card_coverage": ("Coverage", "覆盖率"),
    "scan_card_coverage_note": ("of the model's surface", "占模型表面"),
    "scan_held": ("What the fit can know", "拟合能确定什么"),
    "scan_held_caption": (
        "How well the scan lies in the cable frame. A round, smooth cable shows neither its turn nor a shift "
        "along itself: ribs, dents, paint, spheres or ends do.",
        "扫描在缆索坐标系中的定位精度。光滑圆柱不显示自身的转角与轴向位移；螺旋线、缺陷、表面纹理、球靶或端部可以确定它们。",
    ),
    "scan_way": ("direction", "方向"),
    "scan_sigma": ("σ", "σ"),
    "scan_by": ("held by", "由何确定"),
    "scan_along": ("shift along the cable", "沿缆索位移"),
    "scan_turn": ("turn about the cable", "绕缆索转角"),
    "scan_across": ("shift across", "横向位移"),
    "scan_tilt": ("tilt", "倾斜"),
    "scan_scale": ("scale", "比例"),
    "scan_open": ("not determined", "未确定"),
    "scan_screw": (
        "Turn and shift are tied: {value} mm along the cable for each degree, as the ribs lead.",
        "转角与位移相关：每转一度沿缆索移动 {value} mm，与螺旋线一致。",
    ),
    "scan_deviation": ("Scan − model", "扫描 − 模型"),
    "scan_deviation_caption": (
        "Mean deviation of the scan from the model's surface, unrolled, in cells of 5 mm; red: the scan lies "
        "farther out. The seven parameters are taken out, so a common error of size shows in the scale, not "
        "here.",
        "扫描相对模型表面的平均偏差展开图，网格 5 mm；红色表示扫描在外。七参数已消除，整体尺寸误差见比例。",
    ),
    "scan_diameters": ("Diameters", "直径"),
    "scan_diameters_caption": (
        "Each in its own metres: the scan's scale is not imposed on it.",
        "各自采用自身尺度：扫描直径不受模型比例影响。",
    ),
    "scan_station": ("station", "测点"),
    "scan_position": ("position, m", "位置，m"),
    "scan_photo": ("photos, mm", "影像，mm"),
    "scan_scan": ("scan, mm", "扫描，mm"),
    "scan_difference": ("difference, mm", "差值，mm"),
    "scan_seen": ("seen, °", "可见范围，°"),
    "file_scan.json": ("all figures of this page", "本页全部数据"),
    "file_deviation.png": ("the map of deviations", "偏差图"),
}
