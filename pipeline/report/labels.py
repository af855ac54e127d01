"""Every sentence of the reports in English and Chinese; those of steel surveys: ``steel_labels``.

Gives :func:`label`; a key that is not here raises KeyError.  Texts with numbers carry ``{placeholders}``, the
same ones in both languages.  The Chinese terms are those of the paper.
"""

from dataclasses import dataclass
from typing import Literal, get_args

from pipeline.report.scan_labels import SCAN_TEXTS
from pipeline.report.segment_labels import SEGMENT_TEXTS
from pipeline.report.steel_labels import STEEL_TEXTS

Language = Literal["en", "zh"]
LANGUAGES: tuple[Language, ...] = get_args(Language)


@dataclass(frozen=True, kw_only=True)
class Label:
    """One text in both languages."""

    en: str
    zh: str

    def filled(self, **values: str) -> "Label":
        """The text with its placeholders replaced."""
        return Label(en=self.en.format(**values), zh=self.zh.format(**values))

    def text(self, language: Language) -> str:
        """The text in one language."""
        return self.en if language == "en" else self.zh


def label(key: str, **values: str) -> Label:
    """The text of that key, with its placeholders filled."""
    en, zh = TEXTS[key]
    return Label(en=en, zh=zh).filled(**values)


TEXTS: dict[str, tuple[str, str]] = {
    # Page and header
    "title": ("Cable survey", "缆索测量报告"),
    "subtitle": (
        "Three-dimensional model and diameters of a bridge cable from the videos of a climbing robot",
        "由爬索机器人视频重建的桥梁缆索三维模型与直径",
    ),
    "length": ("{value} m surveyed", "测量长度 {value} m"),
    "block_count": ("{value} blocks", "{value} 个模块"),
    "image_count": ("{value} images", "{value} 张图片"),
    "mean_diameter": ("Mean diameter", "平均直径"),
    "mean_diameter_note": ("over {value} stations", "{value} 个测点的平均"),
    "mae": ("Mean absolute error", "平均绝对误差 MAE"),
    "mae_note": ("paper: 1.0053 mm", "论文：1.0053 mm"),
    "worst_sigma": ("Largest uncertainty σ", "最大标准差 σ"),
    "worst_sigma_note": ("at station {name}", "位于测点 {name}"),
    "calibrated_short": ("Images calibrated", "已校准图片"),
    "calibrated_note": ("{calibrated} of {images}", "{calibrated}/{images}"),
    "straightness": ("Axis straightness", "轴线直线度"),
    "straightness_note": ("largest distance from the chord", "偏离弦线的最大距离"),
    "warnings": ("Please note", "注意事项"),
    "contents": ("Contents", "目录"),
    # Sections
    "diameters": ("Diameters", "直径测量结果"),
    "triangulation": ("Aerial triangulation", "空中三角测量"),
    "lens": ("Lens distortion", "镜头畸变"),
    "lens_effect": ("What the lens correction changes", "畸变校正的效果"),
    "unrolled": ("Unrolled surface", "表面展开图"),
    "model": ("Three-dimensional model", "三维模型"),
    "sections": ("Cross sections", "横截面"),
    "relief": ("Relief: what stands proud or is dented", "表面起伏：凸起与凹陷"),
    "mosaic": ("Mosaicking", "模型拼接"),
    "resources": ("Time and memory", "时间与内存"),
    "files": ("Files of this run", "成果文件"),
    # Table 2
    "diameters_caption": ("Table 2. Diameters at the stations.", "表 2. 各测点直径测量结果。"),
    "diameters_note": (
        "Difference is model minus truth; σ is one standard deviation, the scale included; "
        "coverage is the arc of the section that carries measured points.",
        "差值 = 模型 − 真值；σ 为一倍标准差（含尺度误差）；覆盖角为截面上有测量点的圆弧。",
    ),
    "diameters_note_plain": (
        "σ is one standard deviation, the scale included; "
        "coverage is the arc of the section that carries measured points.",
        "σ 为一倍标准差（含尺度误差）；覆盖角为截面上有测量点的圆弧。",
    ),
    "station": ("Station", "测点"),
    "position_m": ("Position (m)", "位置 (m)"),
    "diameter_mm": ("Diameter (mm)", "模型直径 (mm)"),
    "sigma_mm": ("σ (mm)", "σ (mm)"),
    "min_mm": ("Smallest (mm)", "最小 (mm)"),
    "max_mm": ("Largest (mm)", "最大 (mm)"),
    "coverage_deg": ("Coverage (°)", "覆盖角 (°)"),
    "base_diameter_mm": ("Base (mm)", "基面直径 (mm)"),
    "truth_mm": ("Truth (mm)", "真值 (mm)"),
    "difference_mm": ("Difference (mm)", "差值 (mm)"),
    "relative_percent": ("Relative error (%)", "相对误差 (%)"),
    "paper_diameters_caption": (
        "The paper's Table 2 (Guo et al. 2023), another cable, as printed.",
        "论文表 2（郭文超等，2023），另一根缆索，按原文列出。",
    ),
    "paper_diameters_note": (
        "Row A contradicts itself: 112.383 − 111.4 is +0.983, the paper prints −1.017. "
        "The signs of C and D are printed the other way round too.",
        "A 行自相矛盾：112.383 − 111.4 应为 +0.983，原文为 −1.017；C、D 两行的符号也与其数值不符。",
    ),
    "profile_caption": (
        "Diameter along the cable; the band and the bars are ± σ.",
        "直径沿缆索的变化；色带与误差线为 ± σ。",
    ),
    "profile_caption_plain": (
        "Diameter at the stations; the bars are ± σ.",
        "各测点直径；误差线为 ± σ。",
    ),
    "axis_caption": (
        "Distance of the cable's axis from its chord; straightness {value} mm per metre.",
        "缆索轴线偏离弦线的距离；直线度 {value} mm/m。",
    ),
    # Surface prior
    "surface_prior_caption": (
        "Diameters without and with the weak prior that the surface is locally smooth, from which it may "
        "depart by {sigma} mm: circles through the tie points alone.",
        "不使用与使用弱表面先验（局部光滑，允许偏离 {sigma} mm）的直径对比：仅由连接点拟合圆。",
    ),
    "surface_prior_unused": (
        "The other figures of this report stand on the adjustment without the prior. σ is that of cameras "
        "and lenses.",
        "本报告其余结果均基于不使用先验的平差。σ 仅含相机位姿与镜头的影响。",
    ),
    "surface_prior_used": (
        "The other figures of this report stand on the adjustment with the prior, as asked for. σ is that of "
        "cameras and lenses.",
        "按设置，本报告其余结果基于使用先验的平差。σ 仅含相机位姿与镜头的影响。",
    ),
    "prior_without_mm": ("Without (mm)", "不用先验 (mm)"),
    "prior_with_mm": ("With (mm)", "使用先验 (mm)"),
    "prior_without_sigma_mm": ("σ without (mm)", "不用先验 σ (mm)"),
    "prior_with_sigma_mm": ("σ with (mm)", "使用先验 σ (mm)"),
    # Table 1
    "triangulation_caption": ("Table 1. Result of the aerial triangulation.", "表 1. 空中三角测量结果。"),
    "property": ("Property", "属性"),
    "paper_block1": ("Paper, Block1", "论文 Block1"),
    "images": ("Images", "图片数量"),
    "calibrated": ("Calibrated", "校准数量"),
    "keypoints": ("Keypoints per image", "平均每张影像关键点"),
    "reprojection_px": ("Reprojection error (px)", "重投影误差 (像素)"),
    "coverage_m2": ("Area covered (m²)", "覆盖面积 (m²)"),
    "resolution_mm": ("Resolution (mm/px)", "分辨率 (mm/像素)"),
    "angle_deg": ("Camera azimuth (°)", "相机方位角 (°)"),
    "focal_px": ("Focal length (px)", "焦距 (像素)"),
    "division_lambda": ("Division model λ", "除法模型 λ"),
    "lambda_radius": ("Unit of the radius", "半径单位"),
    "lens_method": ("Lens from", "镜头参数来源"),
    "radius_half-diagonal": ("half-diagonal", "半对角线"),
    "radius_half-width": ("half-width", "半宽"),
    "radius_focal": ("focal length", "焦距"),
    "radius_pixel": ("pixel", "像素"),
    "method_given": ("given", "已知"),
    "method_estimated": ("estimated", "估计"),
    "method_plumb lines": ("plumb lines", "铅垂线法"),
    "method_chessboard": ("chessboard", "棋盘格标定"),
    "method_adjustment": ("adjustment", "平差自检校"),
    "units2": ("{value} square units", "{value} 平方单位"),
    "units_per_px": ("{value} units/px", "{value} 单位/像素"),
    # Lens
    "lens_intro": (
        "One-parameter division model: a point at the radius r of the picture is seen undistorted at "
        "r / (1 + λ r²); λ below zero is a barrel.",
        "单参数除法模型：影像半径 r 处的畸变点，其无畸变位置为 r / (1 + λ r²)；λ 为负值即桶形畸变。",
    ),
    "grid": ("Distortion grid (figure 2)", "畸变网格（图 2）"),
    "before": ("Frame as filmed (figure 3)", "校正前（图 3）"),
    "after": ("Frame corrected (figure 3)", "校正后（图 3）"),
    # Lens effect
    "lens_effect_helps": (
        "Without the lens correction the surface would lie {without} mm (root mean square) off its cylinder; "
        "corrected, it lies {corrected} mm off: {factor} times closer.",
        "未校正镜头畸变时，表面与拟合圆柱的均方根偏差为 {without} mm；校正后为 {corrected} mm，"
        "缩小到原来的 1/{factor}。",
    ),
    "lens_effect_little": (
        "The lens correction hardly changes how well the surface fits its cylinder: "
        "{without} mm without it, {corrected} mm with it.",
        "畸变校正对表面与圆柱的拟合影响不大：未校正 {without} mm，校正后 {corrected} mm。",
    ),
    "lens_effect_worse": (
        "With the lens correction the surface fits its cylinder worse, {corrected} mm instead of "
        "{without} mm: check the lens in the survey.",
        "使用畸变校正后拟合反而变差：{corrected} mm（未校正 {without} mm）。请检查测量文件中的镜头参数。",
    ),
    "lens_effect_truth": (
        "Against the true mean diameter each block alone would be off by {without} mm on average; "
        "corrected, by {corrected} mm.",
        "与真值平均直径相比，单个模块的平均误差由 {without} mm 变为校正后的 {corrected} mm。",
    ),
    "lens_effect_caption": (
        "Each block measured alone, without and with the lens correction.",
        "各模块单独测量：未校正与校正后的对比。",
    ),
    "block": ("Block", "模块"),
    "diameter_without": ("Diameter without (mm)", "未校正直径 (mm)"),
    "diameter_with": ("Diameter with (mm)", "校正后直径 (mm)"),
    "residual_without": ("Residual without (mm)", "未校正残差 (mm)"),
    "residual_with": ("Residual with (mm)", "校正后残差 (mm)"),
    "bow_without": ("Bow without (mm)", "未校正弯曲 (mm)"),
    "bow_with": ("Bow with (mm)", "校正后弯曲 (mm)"),
    "lens_effect_figure": (
        "{block} without (left) and with the correction (right), at one scale. Above: how far the crest "
        "line, seen from the side, rises over the chord between its ends. Below: the section with the "
        "fitted circle (figures 5 and 6 of the paper).",
        "{block} 校正前（左）与校正后（右），比例相同。上：侧视脊线相对其两端弦线的高度；"
        "下：横截面与拟合圆（论文图 5、图 6）。",
    ),
    # Unrolled
    "unrolled_caption": (
        "The whole surface at {scale} mm per pixel: {arc} mm around by {length} mm along the cable. "
        "Click the picture to enlarge it.",
        "整个表面，每像素 {scale} mm：环向 {arc} mm，轴向 {length} mm。点击图片可放大。",
    ),
    "unrolled_file": ("Full resolution: unrolled.png", "原始分辨率：unrolled.png"),
    "unrolled_axes": (
        "Left to right: azimuth {left}° to {right}°. Top to bottom: position {top} m to {bottom} m.",
        "自左至右：方位角 {left}° 至 {right}°；自上而下：位置 {top} m 至 {bottom} m。",
    ),
    "block_pictures": ("What each block contributed", "各模块的展开图"),
    "close": ("Close", "关闭"),
    "point_at": ("azimuth {angle}°, position {position} m", "方位角 {angle}°，位置 {position} m"),
    "actual_size": ("Actual size / fit", "原始大小 / 适应窗口"),
    # 3D
    "viewer_hint": (
        "Drag to turn, click once and use the wheel to zoom, Shift and drag to move along the cable, "
        "double-click to reset.",
        "拖动旋转；单击后用滚轮缩放；按住 Shift 拖动可沿缆索移动；双击复位。",
    ),
    "viewer_texture": ("Texture", "纹理"),
    "viewer_turn": ("Turn", "自动旋转"),
    "viewer_missing": (
        "This browser offers no WebGL, so the model cannot be turned here; open model.glb in a 3D program "
        "instead.",
        "此浏览器不支持 WebGL，无法在此旋转模型；请用三维软件打开 model.glb。",
    ),
    # Plots
    "plot_position": ("position along the cable (m)", "沿缆索位置 (m)"),
    "plot_diameter": ("diameter (mm)", "直径 (mm)"),
    "plot_offset": ("offset of the axis (mm)", "轴线偏移 (mm)"),
    "plot_measured": ("along the cable", "沿缆索"),
    "plot_band": ("± σ", "± σ"),
    "plot_station": ("at the stations", "测点"),
    "plot_truth": ("truth", "真值"),
    "plot_along_x": ("along x", "沿 x"),
    "plot_along_z": ("along z", "沿 z"),
    "plot_seconds": ("time (s)", "时间 (s)"),
    "plot_without": ("without correction", "校正前"),
    "plot_with": ("with correction", "校正后"),
    "plot_height": ("towards the camera (mm)", "朝向相机 (mm)"),
    "plot_crest": ("crest above chord (mm)", "脊线高出弦线 (mm)"),
    "plot_bow": ("bow", "弯曲"),
    "plot_fitted": ("diameter", "直径"),
    "plot_across": ("across (mm)", "横向 (mm)"),
    "sections_caption": (
        "Sections at the stations, seen in the direction of travel. Dashed: the fitted circle; line: the "
        "measured surface, its deviation from the circle drawn {factor} times as large.",
        "各测点横截面（沿行进方向观察）。虚线为拟合圆，实线为测量表面，其与圆的偏差放大 {factor} 倍。",
    ),
    "sections_some": (
        "{shown} of {total} stations are shown.",
        "共 {total} 个测点，显示其中 {shown} 个。",
    ),
    # Relief
    "relief_caption": (
        "What stands out of the base surface, the sheath without it. Height is over the base, of a dent "
        "below it; σ is one standard deviation.",
        "相对基面（去除起伏后的护套表面）的各处起伏。高度相对基面量取，凹陷为低于基面的深度；"
        "σ 为一倍标准差。",
    ),
    "relief_note": (
        "Length is along the cable, width around it, of a ridge across it. A ridge is named where it passes "
        "the middle of the travel; its pitch is positive where the azimuth grows along the cable.",
        "长度沿缆索，宽度沿环向；肋条的宽度垂直于肋条量取，位置取行程中点处的脊线点；"
        "方位角沿行进方向增大时螺距为正。",
    ),
    "relief_none": (
        "Nothing stands out of the base surface by more than {level} mm over an area that can be told from "
        "the noise.",
        "未发现高出或低于基面 {level} mm 以上且可与噪声区分的起伏。",
    ),
    "relief_unknown": (
        "Too little of the surface was seen to tell what stands out of it.",
        "可见表面过少，无法判断起伏。",
    ),
    "relief_map_caption": (
        "Height of the surface over the base, unrolled, seen from outside; the numbers are those of the "
        "table. White: not measured.",
        "展开表面相对基面的高度（自外侧看），编号与表中一致；白色为未测区域。",
    ),
    "relief_number": ("No.", "编号"),
    "relief_kind": ("Kind", "类型"),
    "relief_bulge": ("bulge", "凸起"),
    "relief_dent": ("dent", "凹陷"),
    "relief_ridge": ("ridge", "肋条"),
    "relief_height_mm": ("Height (mm)", "高度 (mm)"),
    "relief_azimuth_deg": ("Azimuth (°)", "方位角 (°)"),
    "relief_length_mm": ("Length (mm)", "长度 (mm)"),
    "relief_width_mm": ("Width (mm)", "宽度 (mm)"),
    "relief_pitch_m": ("Pitch (m)", "螺距 (m)"),
    "plot_azimuth": ("azimuth (°)", "方位角 (°)"),
    "plot_relief": ("height over the base (mm)", "相对基面高度 (mm)"),
    # Mosaic
    "together_caption": (
        "All cameras were adjusted together as one rig, tied by {value} marks that neighbours share (root "
        "mean square residual {residual} px). How well the surfaces fit where they overlap:",
        "所有相机作为一个整体联合平差，相邻模块共享 {value} 个标志点（残差均方根 {residual} 像素）。"
        "相邻表面重叠处的吻合程度：",
    ),
    "rolling_shutter": (
        "The rows of a frame are read one after the other (rolling shutter): meanwhile the robot travels "
        "{value} ± {sigma} mm. This has been put right.",
        "影像逐行曝光（卷帘快门）：读出一帧期间机器人行进 {value} ± {sigma} mm，已予改正。",
    ),
    "mosaic_caption": (
        "Single-point mosaicking of neighbouring blocks; {value} tie points are seen from more than one "
        "block.",
        "相邻模块的单点对齐拼接；跨模块连接点共 {value} 个。",
    ),
    "joint": ("Neighbours", "相邻模块"),
    "pairs": ("Corresponding points", "对应点数"),
    "joint_residual": ("Residual (mm)", "残差 (mm)"),
    "scale_caption": ("Scale given to each block in the mosaic.", "拼接时各模块的尺度改正。"),
    "scale_correction": ("Scale correction", "尺度改正"),
    # Resources
    "timing_caption": (
        "{total} s in all; peak memory {memory} MB.",
        "总计 {total} s；内存峰值 {memory} MB。",
    ),
    "stage": ("Stage", "步骤"),
    "stage_survey": ("survey", "读取测量文件"),
    "stage_frames": ("frames", "抽取影像"),
    "stage_lens": ("lens", "镜头校正"),
    "stage_pos": ("POS", "POS 构造"),
    "stage_match": ("match", "影像匹配"),
    "stage_adjust": ("adjust", "平差"),
    "stage_closing": ("closing", "闭合匹配"),
    "stage_joint": ("joint", "整体平差"),
    "stage_undistort": ("undistort", "影像去畸变"),
    "stage_dense": ("dense", "密集匹配"),
    "stage_surface": ("surface", "构网"),
    "stage_texture": ("texture", "纹理映射"),
    "stage_crop": ("crop", "裁剪"),
    "stage_mosaic": ("mosaic", "拼接"),
    "stage_ring": ("ring", "合成整环"),
    "stage_measure": ("measure", "直径测量"),
    "stage_report": ("report", "报告"),
    # Files
    "file_report.json": ("all figures of this page", "本页全部数据"),
    "file_diameters.csv": ("the stations for a spreadsheet", "测点数据（表格）"),
    "file_model.glb": ("textured model", "带纹理模型"),
    "file_model.ply": ("model for point cloud programs", "点云软件用模型"),
    "file_cloud.ply": ("dense points", "密集点云"),
    "file_unrolled.png": ("unrolled surface", "表面展开图"),
    "frame_note": (
        "Metres; y is the cable's axis in the direction of travel, y = 0 at the first frame; azimuth a is "
        "the direction (cos a, 0, −sin a).",
        "单位米；y 轴为缆索轴线，指向行进方向，首帧处 y = 0；方位角 a 的方向为 (cos a, 0, −sin a)。",
    ),
    **STEEL_TEXTS,
    **SCAN_TEXTS,
    **SEGMENT_TEXTS,
}
