"""The area *Export*."""

ZH = {
    "Export": "导出",
    "Copy the chosen files of the finished run to the folder": "将已完成结果中所选的文件复制到文件夹",
    "{} files copied to {}": "已将 {} 个文件复制到 {}",
    "Open Report": "打开报告",
    "Open the report in the web browser; it needs no network": "在浏览器中打开报告，无需网络",
    "Show the exported files in the file manager; before an export, the run's own": (
        "在文件管理器中显示导出的文件；导出之前显示结果文件夹"
    ),
    "The run is not finished yet": "重建尚未完成",
    "Folder": "文件夹",
    "Where the copies go; older ones are replaced": "副本的存放位置，旧副本将被替换",
    "report.html: one page with pictures, tables and plots": "report.html：含图片、表格和图表的网页",
    "Diameters (CSV)": "直径 (CSV)",
    "diameters.csv: the stations, for a spreadsheet": "diameters.csv：各测点直径，供电子表格使用",
    "Textured model (GLB)": "纹理模型 (GLB)",
    "model.glb: the cable with its texture": "model.glb：带纹理的索模型",
    "Model (PLY)": "模型 (PLY)",
    "model.ply: the cable with a colour for each vertex": "model.ply：逐顶点着色的索模型",
    "Point cloud (PLY)": "点云 (PLY)",
    "cloud.ply: the dense points with normals and colours": "cloud.ply：带法线和颜色的密集点",
    "Unrolled surface (PNG)": "展开表面 (PNG)",
    "unrolled.png: the whole surface laid flat, to scale": "unrolled.png：按比例展开的整个表面",
}
