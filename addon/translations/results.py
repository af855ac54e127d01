"""The area *Results*."""

ZH = {
    "Results": "成果",
    "Open Results": "打开成果",
    "Show what the run folder holds, finished or half finished": "显示结果文件夹中的内容，无论是否全部完成",
    "Open Run Folder": "打开结果文件夹",
    "Choose a run folder and show what it holds": "选择结果文件夹并显示其内容",
    "Open Folder": "打开文件夹",
    "Reload": "重新载入",
    "Segment": "分段",
    "Which segment of a long survey is shown, from 1; Reload shows another one": (
        "显示长测量项目的哪一分段，从 1 起；按“重新载入”显示另一分段"
    ),
    "How many segments the run has; 0 where it was not cut": "结果的分段数；未分段时为 0",
    "Nothing is shown yet": "尚未显示任何成果",
    "{} of {}": "{} / {}",
    "Error (px)": "误差 (px)",
    "The report is there": "报告已生成",
    "Stamp of the adjustment that placed the block": "确定条带位置的平差结果标识",
    "One sentence a line": "每行一句",
    "Setup": "布设",
    "Sparse points": "稀疏点",
    "Dense cloud": "密集点云",
    "Block meshes": "条带网格",
    "Pairs": "同名点对",
}
