"""The area *Mosaic*."""

ZH = {
    "First block": "第一条带",
    "Second block": "第二条带",
    "First point": "第一点",
    "Second point": "第二点",
    "Block of the first point": "第一点所在的条带",
    "Block of the second point": "第二点所在的条带",
    "Mark on the first block, in its own frame": "第一条带上的标志点，采用该条带自身的坐标系",
    "The same mark on the second block, in its own frame": "第二条带上的同一标志点，采用该条带自身的坐标系",
    "Residual": "残差",
    "Distance of the two points as the blocks stand now, millimetres": "按条带当前位置计算的两点距离（毫米）",
    "Found": "自动找到",
    "Found automatically to close the ring": "为闭合圆环而自动找到",
    "Join": "拼接方式",
    "Where the corresponding points come from": "同名点的来源",
    "Found in the blocks' pictures": "从各条带的影像中自动匹配",
    "The pairs below; the first of each two blocks is held together": (
        "采用下面的点对；每两个条带的第一对点保持重合"
    ),
    "Pair": "点对",
    "The pair that is chosen": "选中的点对",
    "Where the first point is picked; empty takes any block": "在其上选取第一点；留空则为任意条带",
    "Where the second point is picked; empty takes any other block": "在其上选取第二点；留空则为任意其他条带",
    "Fit": "拟合",
    "Bring the blocks as close as they go, the first pair of each two held together": (
        "在每两个条带的第一对点重合的情况下，使各条带尽可能贴合"
    ),
    "Close the Ring": "闭合圆环",
    "Add an automatic pair for every two neighbours that have none, the last and the first included, "
    "and fit all blocks at once": (
        "为每两个尚无点对的相邻条带（包括首尾两个）自动添加一对点，并整体拟合所有条带"
    ),
    "Look at Seam": "查看接缝",
    "Hide all other blocks and look at where these two meet": "隐藏其他条带，查看这两个条带的接缝",
    "Choose two blocks or a pair": "请选择两个条带或一个点对",
    "Show All Blocks": "显示所有条带",
    "Show All": "全部显示",
    "Show the blocks that were hidden": "显示被隐藏的条带",
    "Join the blocks as the panel says and make again what rests on it": (
        "按面板设置拼接条带，并重新计算依赖拼接的各阶段"
    ),
    "Joined": "拼接完成",
    "Pick Pairs": "选取点对",
    "Click a mark on one block, then the same mark on another; Esc or right click ends": (
        "先点击一个条带上的标志点，再点击另一条带上的同一标志点；按 Esc 或右键结束"
    ),
    "Pick in a 3D view": "请在三维视图中选取",
    "No block is there": "该处没有条带",
    "Click a mark on {}": "点击 {} 上的标志点",
    "a block": "一个条带",
    "another block": "另一条带",
    "{}: now the same mark on {}": "{}：现在点击 {} 上的同一标志点",
    "{}    Esc: end    Ctrl Z: back": "{}    Esc：结束    Ctrl Z：撤回",
    "Remove Pair": "移除点对",
    "Its place in the list; -1 is the chosen one": "在列表中的序号；-1 表示选中的点对",
    "Take the chosen pair out of the list": "从列表中移除选中的点对",
    "Remove All Pairs": "移除所有点对",
    "Take all pairs out of the list": "从列表中移除所有点对",
    "Hold Together": "保持重合",
    "Hold this pair together when fitting, instead of the first one of its two blocks": (
        "拟合时使该点对保持重合，代替这两个条带的第一对点"
    ),
    "Read Pairs": "读取点对",
    "Read pairs from a CSV file, such as the run folder's pairs.csv, in place of these": (
        "从 CSV 文件（如结果文件夹中的 pairs.csv）读取点对，替换当前列表"
    ),
    "Seam": "接缝",
    "Residual (mm)": "残差 (mm)",
    "Left over (mm)": "剩余差异 (mm)",
    "Points": "点",
    "Some pairs were picked before the blocks were adjusted anew: pick them again": (
        "有些点对是在条带重新平差之前选取的：请重新选取"
    ),
    "Stamp of the first block's adjustment when picked": "选取时第一条带平差结果的标识",
    "Stamp of the second block's adjustment when picked": "选取时第二条带平差结果的标识",
}
