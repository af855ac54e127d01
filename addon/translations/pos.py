"""The area *POS*."""

ZH = {
    "POS from": "POS 来源",
    "Where the exterior orientation of the frames comes from": "各帧外方位元素的来源",
    "Constructed from the travel: even steps along the axis, nominal attitude": (
        "由行程构造：沿轴线等间隔，姿态取标称值"
    ),
    "CSV file": "CSV 文件",
    "Measured, read from a file": "实测值，读自文件",
    "File": "文件",
    "Import POS": "导入 POS",
    "Read the chosen block's exterior orientation from a CSV file, and see which names match": (
        "从 CSV 文件读取所选条带的外方位元素，并查看名称的匹配情况"
    ),
    "Check Again": "重新检查",
    "Look again which rows of the file match the frames": "重新检查文件中的哪些行与帧匹配",
    "Show Camera Paths": "显示相机轨迹",
    "Draw where the cameras are taken to have been, constructed or measured": (
        "绘制各相机的位置轨迹（构造或实测）"
    ),
    "Write POS": "写出 POS",
    "Write the constructed exterior orientation of every frame as CSV, to be edited and imported": (
        "把构造的各帧外方位元素写成 CSV，以便编辑后再导入"
    ),
    "frame {}": "第 {} 帧",
    "{} rows match a frame": "{} 行与帧匹配",
    "{} rows match none": "{} 行无匹配的帧",
    "{} frames have no row": "{} 帧没有对应的行",
    "Number of the frame in its video": "该帧在视频中的编号",
    "State": "状态",
    "What became of this row": "该行的匹配结果",
    "Matched": "已匹配",
    "The row has found its frame": "该行已找到对应的帧",
    "No such frame": "无此帧",
    "The name is no frame of this block": "该名称不是本条带的帧",
    "Named twice": "重复",
    "An earlier row names the same frame": "前面的行已指向同一帧",
    "No row": "无对应行",
    "The file says nothing of this frame": "文件中没有该帧",
    "Row": "行",
    "The row that is chosen": "所选的行",
    "Name of the block whose file was looked at": "所检查文件对应的条带名称",
    "The file that was looked at": "所检查的文件",
    "Rows that found their frame": "找到对应帧的行",
    "Without a frame": "无对应帧",
    "Rows that found none": "未找到对应帧的行",
    "Without a row": "无对应行",
    "Frames of the video without a row": "视频中没有对应行的帧",
    "What the reconstruction would refuse the file for": "重建会拒绝该文件的原因",
    "Camera paths": "相机轨迹",
}
