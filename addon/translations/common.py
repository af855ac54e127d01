"""Preferences, and strings that more than one area uses."""

ZH = {
    "Cancel": "取消",
    "Cancelled": "已取消",
    "Run": "运行",
    "{stage}: {cause}. What to do: {remedy}": "{stage}：{cause}。解决办法：{remedy}",
    "Cancelling": "正在取消",
    "Report language": "报告语言",
    "Language in which the report opens": "打开报告时所用的语言",
    "English": "英文",
    "Chinese": "中文",
    "Simplified Chinese": "简体中文",
    "Points shown": "显示点数",
    "Most points of a cloud that are loaded; larger clouds are thinned evenly, files are not": (
        "点云载入的最多点数；更大的点云会均匀抽稀，文件不受影响"
    ),
}
