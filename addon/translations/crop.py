"""The area *Crop*."""

ZH = {
    "Largest angle between the line of sight and the surface's normal": "视线与表面法线之间允许的最大夹角",
    "Agreement": "一致性",
    "Smallest agreement of the frames": "各帧影像之间的最低一致性",
    "Fringe": "毛边",
    "Protrusions and islands narrower than this are cut": "窄于此宽度的突出部分和孤岛将被裁去",
    "Start at": "起点",
    "End at": "终点",
    "Cut what lies before a station": "裁去某一位置之前的部分",
    "Cut what lies behind a station": "裁去某一位置之后的部分",
    "Stays": "保留",
    "Share of the surface that stays": "保留的表面比例",
    "What is cut is shown on the uncropped blocks": "在未裁剪的条带上显示将被裁去的部分",
    "Why the options cannot be used": "这些选项不能使用的原因",
    "Collections that the preview has hidden, one a line": "预览时隐藏的集合，每行一个",
    "Preview": "预览",
    "End Preview": "结束预览",
    "Show the whole blocks with what would be cut in red, live while options change": (
        "显示完整的条带，将被裁去的部分标为红色，并随选项实时更新"
    ),
    "Reset": "重置",
    "Go back to the options that the pipeline starts with": "恢复为默认选项",
    "Apply": "应用",
    "Write the options to the survey and make again what rests on the crop": (
        "将选项写入测量文件，并重新计算依赖裁剪的各阶段"
    ),
    "Open a run folder first": "请先打开结果文件夹",
    "Cropped": "裁剪完成",
    "Crop preview": "裁剪预览",
}
