"""The area *Measure*."""

ZH = {
    "Nothing is measured yet": "尚未量测",
    "Add": "添加",
    "Remove": "移除",
    "View": "查看",
    "Add Station on the Cable": "在索上添加测点",
    "Click on the cable to add a station there": "在索面上单击以添加测点",
    "Click on the cable to add a station, Esc to leave": "在索面上单击以添加测点，按 Esc 退出",
    "Open a measured run first": "请先打开已量测的结果",
    "View Station": "查看测点",
    "Turn the view to the chosen station": "将视图转到所选测点",
    "View Feature": "查看起伏",
    "Turn the view square to this place": "将视图正对此处",
    "Feature": "起伏",
    "Its number in the list": "在列表中的序号",
    "Measure the survey's stations; only what rests on them is made again": (
        "量测各测点；只重新计算依赖测点的部分"
    ),
    "Open the survey of this run first": "请先打开该结果对应的测量文件",
    "Measured": "量测完成",
    "Exaggeration": "放大倍数",
    "How much larger than true the section's deviation from its mean circle is drawn": (
        "截面相对其平均圆的偏差在绘制时的放大倍数"
    ),
    "What the colour of the surface shows": "表面颜色所表示的内容",
    "The surface as the cameras saw it": "相机所见的表面",
    "Deviation from mean": "相对平均值的偏差",
    "Distance from a tube of the mean diameter about the axis": "到以轴线为中心、平均直径圆管的距离",
    "Deviation from nominal": "相对公称值的偏差",
    "Distance from a tube of the nominal diameter": "到公称直径圆管的距离",
    "Relief": "起伏",
    "Height over the base surface: what stands proud or is dented": "相对基准面的高度：凸起或凹陷",
    "Range (mm)": "范围 (mm)",
    "Deviation at which the colours end, outwards and inwards, in millimetres": (
        "颜色终止处向外和向内的偏差，单位毫米"
    ),
    "Diameter of the profile there until the station is measured; 0 unknown": (
        "测点量测之前，该处剖面的直径；0 表示未知"
    ),
    "Diameter (mm)": "直径 (mm)",
    "Bulge": "鼓包",
    "Dent": "凹坑",
    "Ridge": "螺旋线",
    "Chosen station": "所选测点",
    "From the profile; press Measure": "取自剖面；请按“量测”",
    "Smallest": "最小",
    "Largest": "最大",
    "Seen": "可见角度",
    "Difference": "差值",
    "Against the truth": "与真值比较",
    "Choose a truth.json and press Measure": "请选择 truth.json 并按“量测”",
    "Mean absolute error": "平均绝对误差",
    "Nothing stands out": "没有明显起伏",
    "Display": "显示",
}
