"""The sentences of the steel report in English and Chinese, for ``pipeline.report.labels``, which holds all.

Gives STEEL_TEXTS, key to (English, Chinese) with the same ``{placeholders}``.  Keys begin with ``steel_``,
texts inside plots with ``plot_``, times with ``stage_``, files with ``file_``.  The Chinese terms are those
of the paper (guo-ming-2021).
"""

STEEL_TEXTS: dict[str, tuple[str, str]] = {
    # Page and header
    "steel_title": ("Steel structure survey", "钢结构测量报告"),
    "steel_subtitle": (
        "Registration of laser scans in one adjustment; node eccentricity, column inclination and grid "
        "deflection",
        "多站激光点云整体平差配准；球节点偏心、钢柱倾斜与网架挠度",
    ),
    "steel_station_count": ("{value} stations", "{value} 个测站"),
    "steel_target_count": ("{value} targets", "{value} 个靶标"),
    "steel_base_fact": ("base station {value}", "基站 {value}"),
    "steel_control_fact": ("frame from control targets", "坐标系由控制靶标确定"),
    "steel_card_residual": ("Registration", "整体配准"),
    "steel_card_residual_note": ("3D residual, rms; paper: 5 mm", "三维残差均方根；论文：5 mm"),
    "steel_card_sigma": ("Largest station σ", "测站最大标准差 σ"),
    "steel_card_sigma_note": ("of a coordinate, at {name}", "坐标分量，位于 {name}"),
    "steel_card_gross": ("Gross errors", "粗差"),
    "steel_card_gross_note": ("of {value} observations", "共 {value} 个观测"),
    "steel_card_columns": ("Columns over limit", "超限钢柱"),
    "steel_card_columns_note": ("of {count}; limit {limit} mm", "共 {count} 根；限值 {limit} mm"),
    "steel_card_nodes": ("Eccentric nodes", "偏心球节点"),
    "steel_card_nodes_note": ("of {count}; largest {largest} mm", "共 {count} 个；最大 {largest} mm"),
    "steel_card_nodes_none": ("of {count} nodes judged", "共检测 {count} 个"),
    "steel_card_deflection": ("Largest deflection", "最大挠度"),
    "steel_card_deflection_note": ("limit {limit} mm", "限值 {limit} mm"),
    # Sections
    "steel_registration": ("Registration", "整体配准"),
    "steel_chain": ("Error along the chain", "误差沿测站链的传播"),
    "steel_model": ("Fitted structure", "拟合结构三维视图"),
    "steel_columns": ("Columns", "钢柱倾斜"),
    "steel_nodes": ("Node eccentricity", "球节点偏心"),
    "steel_deflection": ("Deflection of the grid", "网架挠度"),
    "steel_fusion": ("Photos and scans together", "影像与激光点云融合"),
    "steel_truth": ("Against the truth", "与真值比较"),
    "steel_paper": ("Beside the paper", "与论文对照"),
    # Registration
    "steel_registration_lead": (
        "{stations} stations and {targets} targets were adjusted together; the {observations} observations "
        "fit within {rms} mm (root mean square, 3D). Rounds of re-weighting: {rounds}.",
        "{stations} 个测站与 {targets} 个靶标整体平差；{observations} 个观测的三维残差均方根为 {rms} mm。"
        "定权迭代次数：{rounds}。",
    ),
    "steel_registration_figures": (
        "With them {axes} axes of columns and rods and {planes} planes, found in the clouds and seen by two "
        "stations or more.",
        "同时参与平差的还有从点云中提取、至少两站可见的 {axes} 条柱杆轴线与 {planes} 个平面。",
    ),
    "steel_plan_caption": (
        "Stations and targets from above. Ellipses: one standard deviation of the station's position, drawn "
        "{factor} times as large; thin lines: which station each one was first placed from.",
        "测站与靶标平面图。椭圆为测站位置的一倍标准差，放大 {factor} 倍；细线表示初值由哪一站传递而来。",
    ),
    "steel_stations_caption": ("Stations in the site frame.", "测站在现场坐标系中的位置。"),
    "steel_stations_note": (
        "σ is the standard deviation of one coordinate (root mean of the three), σ of the attitude likewise; "
        "ring: set-ups away from the base.",
        "σ 为单个坐标的标准差（三个分量的均方根），姿态 σ 同理；环数为距基站的设站次数。",
    ),
    "steel_station": ("Station", "测站"),
    "steel_x_m": ("x (m)", "x (m)"),
    "steel_y_m": ("y (m)", "y (m)"),
    "steel_z_m": ("z (m)", "z (m)"),
    "steel_sigma_mm": ("σ (mm)", "σ (mm)"),
    "steel_sigma_arcsec": ("σ attitude (″)", "姿态 σ (″)"),
    "steel_ring": ("Ring", "环数"),
    "steel_parent": ("Placed from", "初值来自"),
    "steel_base": ("base", "基站"),
    "steel_gross_heading": ("Gross errors", "粗差"),
    "steel_gross_none": (
        "No observation contradicts the others: no gross error.",
        "各观测互不矛盾，未发现粗差。",
    ),
    "steel_gross_lead": (
        "These observations cannot be noise; they were left out of the adjustment.",
        "下列观测不能用噪声解释，已从平差中剔除。",
    ),
    "steel_gross_moved": (
        "{target} seen from {station} lies {size} ± {sigma} mm off where the other stations see it: it was "
        "moved.",
        "从 {station} 观测的 {target} 偏离其他测站所见位置 {size} ± {sigma} mm：靶标曾被移动。",
    ),
    "steel_gross_misnamed": (
        "What {station} calls {target} is another target: it stands {size} m off {target}.",
        "{station} 中名为 {target} 的靶标并非 {target}：两者相距 {size} m。",
    ),
    "steel_gross_fits": ("It stands where {fits} is.", "其位置与 {fits} 相符。"),
    "steel_gross_moved_many": (
        "{target} was moved: {stations} see it at one place, {least} to {most} mm off where others see it.",
        "{target} 曾被移动：{stations} 在同一位置观测到它，偏离其他测站所见位置 {least}～{most} mm。",
    ),
    "steel_gross_instead": (
        "Only {instead} sees it as well: which of the two is wrong cannot be told.",
        "仅 {instead} 另行观测到该靶标，无法判断两者谁错。",
    ),
    "steel_components_caption": (
        "Variance components: how well each kind of observation fits.",
        "方差分量：各类观测的符合程度。",
    ),
    "steel_components_note": (
        "The factor is the standard deviation found over the one stated in the survey; near 1 the stated "
        "accuracy was right.",
        "比值 = 验后标准差 / 测量文件给定的标准差；接近 1 表示给定精度恰当。",
    ),
    "steel_kind": ("Kind", "类别"),
    "steel_kind_point": ("points (targets)", "点（靶标）"),
    "steel_kind_line": ("lines (axes)", "线（轴线）"),
    "steel_kind_plane": ("planes", "面"),
    "steel_kind_plumb": ("plumb (levelled)", "铅垂（整平）"),
    "steel_kind_control": ("control", "控制点"),
    "steel_factor": ("Factor", "比值"),
    "steel_observations": ("Observations", "观测数"),
    "steel_redundancy": ("Redundancy", "多余观测数"),
    "steel_residuals_caption": (
        "Residuals of the observations, coordinate by coordinate; the curve is the normal distribution with "
        "their standard deviation of {sigma} mm.",
        "各坐标分量的观测残差；曲线为同一标准差（{sigma} mm）的正态分布。",
    ),
    # Chain
    "steel_chain_lead": (
        "Registered station by station, the last ring of stations lies {chained} mm off its adjusted place; "
        "its predicted standard deviation is {chained_sigma} mm, in the adjustment {adjusted_sigma} mm.",
        "逐站配准时，最外环测站偏离整体平差位置 {chained} mm；其预期标准差为 {chained_sigma} mm，"
        "整体平差为 {adjusted_sigma} mm。",
    ),
    "steel_chain_icp": (
        "Pairwise ICP, chained along the same tree, ends {icp} mm off.",
        "沿同一路径逐对 ICP 的末端偏差为 {icp} mm。",
    ),
    "steel_chain_caption": (
        "How far each station lies off its adjusted place when registered station by station, and how far it "
        "may be expected to lie off the truth (one standard deviation of the place).",
        "各测站逐站配准结果与整体平差位置之差，以及位置的预期误差（一倍标准差）。",
    ),
    "steel_chain_truth_caption": (
        "Distance of each station from its true place. Left: as it stands, relative to the base, whose own "
        "attitude turns the whole site; dashed: the standard deviations predicted without knowing the truth. "
        "Right: each way after its own best rigid fit to the truth.",
        "各测站与真实位置的距离。左：相对于基站直接比较，基站自身的姿态误差使整体产生旋转；"
        "虚线为未使用真值时预期的标准差。右：各方法分别经最佳刚体拟合之后。",
    ),
    "steel_icp_caption": ("Pairwise ICP, the worst pairs first.", "逐对 ICP 结果，偏差最大者在前。"),
    "steel_pair": ("Pair", "测站对"),
    "steel_offset_mm": ("Off the adjustment (mm)", "与平差之差 (mm)"),
    "steel_turn_arcsec": ("Turn (″)", "转角差 (″)"),
    "steel_rms_mm": ("Fit (mm)", "拟合残差 (mm)"),
    "steel_matched": ("Matched (%)", "匹配率 (%)"),
    "steel_converged": ("Converged", "收敛"),
    "steel_yes": ("yes", "是"),
    "steel_no": ("no", "否"),
    # Model
    "steel_viewer_hint": (
        "Drag to turn, Shift and drag to move, click once and use the wheel to zoom, double-click to reset.",
        "拖动旋转；按住 Shift 拖动平移；单击后用滚轮缩放；双击复位。",
    ),
    "steel_viewer_lean": (
        "Arrows at the columns: their lean, {factor} times as large.",
        "柱顶箭头为倾斜量，放大 {factor} 倍。",
    ),
    "steel_viewer_apart": (
        "Arrows at the nodes: eccentricity, {factor} times as large.",
        "节点箭头为偏心量，放大 {factor} 倍。",
    ),
    "steel_viewer_missing": (
        "This browser offers no WebGL; open members.glb in a 3D program instead.",
        "此浏览器不支持 WebGL；请用三维软件打开 members.glb。",
    ),
    "steel_viewer_rods": ("Rods", "杆件"),
    "steel_viewer_balls": ("Balls", "球节点"),
    "steel_viewer_columns": ("Columns", "钢柱"),
    "steel_viewer_arrows": ("Arrows", "箭头"),
    "steel_viewer_stations": ("Stations", "测站"),
    "steel_viewer_names": ("Names", "名称"),
    "steel_members_caption": (
        "{rods} rods, {balls} balls and {columns} columns were fitted in the registered cloud.",
        "在配准点云中共拟合 {rods} 根杆件、{balls} 个球、{columns} 根柱。",
    ),
    # Columns
    "steel_columns_lead": (
        "{over} of {count} columns lean more than {limit} mm; the most, {name}, by {largest} mm.",
        "{count} 根钢柱中有 {over} 根倾斜超过 {limit} mm；最大者为 {name}，{largest} mm。",
    ),
    "steel_columns_unsure": (
        "Within two standard deviations of the limit, on either side: {count}.",
        "其中 {count} 根与限值之差在两倍标准差以内。",
    ),
    "steel_columns_plan": (
        "The columns from above. Arrows: how far the top is off the bottom, drawn {factor} times as large.",
        "钢柱平面图。箭头为柱顶相对柱底的偏差，放大 {factor} 倍。",
    ),
    "steel_columns_caption": (
        "Inclination of the columns, as in the paper's Table 1.",
        "钢柱倾斜（格式同论文表 1）。",
    ),
    "steel_columns_note": (
        "Positive is north and east of the bottom; 1/n is the deviation over the height difference. "
        "“near” marks a deviation within two σ of the limit.",
        "正值表示柱顶偏北、偏东；1/n 为偏差与高差之比。“临界”表示与限值之差在两倍 σ 以内。",
    ),
    "steel_column": ("Column", "钢柱"),
    "steel_north_mm": ("North (mm)", "北 (mm)"),
    "steel_east_mm": ("East (mm)", "东 (mm)"),
    "steel_deviation_mm": ("Deviation (mm)", "偏差 (mm)"),
    "steel_direction": ("Leans", "倾斜方向"),
    "steel_height_mm": ("Height difference (mm)", "测点高差 (mm)"),
    "steel_ratio": ("Ratio", "垂直偏差"),
    "steel_verdict": ("Limit {limit} mm", "限值 {limit} mm"),
    "steel_over": ("over", "超限"),
    "steel_within": ("within", "合格"),
    "steel_over_near": ("over, near", "超限（临界）"),
    "steel_within_near": ("within, near", "合格（临界）"),
    "steel_wind_north": ("north", "北"),
    "steel_wind_north-east": ("north-east", "东北"),
    "steel_wind_east": ("east", "东"),
    "steel_wind_south-east": ("south-east", "东南"),
    "steel_wind_south": ("south", "南"),
    "steel_wind_south-west": ("south-west", "西南"),
    "steel_wind_west": ("west", "西"),
    "steel_wind_north-west": ("north-west", "西北"),
    "steel_wind_nowhere": ("–", "–"),
    # Nodes
    "steel_nodes_lead": (
        "{significant} of {count} nodes are eccentric: ball and rods' meeting point are farther apart than "
        "noise explains.",
        "{count} 个球节点中有 {significant} 个存在偏心：球心与杆件轴线交会点之差不能用噪声解释。",
    ),
    "steel_nodes_none": (
        "None of {count} nodes is eccentric beyond what noise explains.",
        "{count} 个球节点的偏心量均可用噪声解释，无显著偏心。",
    ),
    "steel_nodes_plan": (
        "The judged nodes from above. Arrows: from where the rods meet to the ball's centre, their part in "
        "plan, drawn {factor} times as large; rings: not significant.",
        "所检测球节点平面图。箭头由杆件交会点指向球心（平面分量），放大 {factor} 倍；圆圈为不显著者。",
    ),
    "steel_nodes_sizes": (
        "Eccentricity of each node with its standard deviation, the largest first.",
        "各节点的偏心量及其标准差，由大到小。",
    ),
    "steel_nodes_caption": ("Eccentricity of the ball nodes, the largest first.", "球节点偏心，由大到小。"),
    "steel_nodes_some": (
        "{shown} of {total} nodes are shown; all stand in nodes.csv.",
        "共 {total} 个节点，显示其中 {shown} 个；全部见 nodes.csv。",
    ),
    "steel_nodes_note": (
        "Ball less rods, site frame. Common perpendiculars: distance of the paper's centre (equations 8 to "
        "14) from the least-squares one.",
        "球心减杆件交会点，现场坐标系。公垂线：论文方法（式 8–14）所得中心与最小二乘中心之距。",
    ),
    "steel_node": ("Node", "节点"),
    "steel_rod_count": ("Rods", "杆件数"),
    "steel_dx_mm": ("x (mm)", "x (mm)"),
    "steel_dy_mm": ("y (mm)", "y (mm)"),
    "steel_dz_mm": ("z (mm)", "z (mm)"),
    "steel_size_mm": ("Eccentricity (mm)", "偏心量 (mm)"),
    "steel_significant": ("Significant", "显著"),
    "steel_perpendiculars_mm": ("Common perp. (mm)", "公垂线 (mm)"),
    # Deflection
    "steel_deflection_lead": (
        "The grid hangs {largest} ± {sigma} mm below its supports at most, at {node}: 1/{ratio} of the span "
        "of {span} m.",
        "网架相对支座的最大挠度为 {largest} ± {sigma} mm，位于 {node}，为跨度 {span} m 的 1/{ratio}。",
    ),
    "steel_deflection_holds": ("The limit of {limit} mm is kept.", "满足限值 {limit} mm 的要求。"),
    "steel_deflection_fails": ("The limit of {limit} mm is exceeded.", "超过限值 {limit} mm。"),
    "steel_deflection_caption": (
        "Deflection of the nodes in mm, from above; positive is down. Squares: supports.",
        "节点挠度平面分布（mm），向下为正；方框为支座。",
    ),
    "steel_deflection_profile": (
        "The same along the structure, one standard deviation as a bar, the limit dashed.",
        "沿结构方向的挠度，误差线为一倍标准差，虚线为限值。",
    ),
    # Fusion
    "steel_fusion_lead": (
        "The photo model lies {median} mm (median) off the scanned surface over {overlap} % of its points; "
        "its scale is known to {scale} %.",
        "影像点云 {overlap} % 的点与扫描表面的中位距离为 {median} mm；尺度标准差 {scale} %。",
    ),
    "steel_fusion_pairs": ("Places that photos and scans share.", "影像与点云的公共点。"),
    "steel_fusion_undetermined": ("Nothing determines: {value}.", "无法确定：{value}。"),
    "steel_fusion_caption": (
        "Distances of the photo model from the scanned surface.",
        "影像点云到扫描表面的距离。",
    ),
    "steel_target_name": ("Place", "公共点"),
    "steel_residual_mm": ("Residual (mm)", "残差 (mm)"),
    # Truth
    "steel_truth_caption": (
        "This run against what is true; the targets are those asked for a hall of 12 stations.",
        "本次结果与真值比较；目标值针对 12 站的厅馆。",
    ),
    "steel_figure": ("Figure", "指标"),
    "steel_found": ("Found", "结果"),
    "steel_wanted": ("Target", "目标"),
    "steel_truth_position": ("Station positions, RMS (mm)", "测站位置均方根误差 (mm)"),
    "steel_truth_attitude": ("Station attitudes, RMS (″)", "测站姿态均方根误差 (″)"),
    "steel_truth_fitted": ("The same after the best rigid fit (mm)", "最佳刚体拟合后 (mm)"),
    "steel_truth_chained": (
        "Station by station, as it stands and fitted (mm)",
        "逐站配准：直接比较与拟合后 (mm)",
    ),
    "steel_truth_icp": ("Pairwise ICP, as it stands and fitted (mm)", "逐对 ICP：直接比较与拟合后 (mm)"),
    "steel_truth_sigma_share": ("Errors within 2 σ (%)", "误差在 2σ 以内 (%)"),
    "steel_truth_sigma_ratio": ("σ over RMS error", "σ 与均方根误差之比"),
    "steel_truth_gross": ("Gross errors named, missed, false", "粗差：找到、漏判、误判"),
    "steel_truth_nodes": ("Eccentricity, RMS error (mm)", "偏心量均方根误差 (mm)"),
    "steel_truth_nodes_false": ("Nodes false, missed", "节点误判、漏判"),
    "steel_truth_columns": ("Column deviation, largest error (mm)", "钢柱偏差最大误差 (mm)"),
    "steel_truth_columns_right": ("Columns judged right", "钢柱判定正确数"),
    "steel_truth_deflection": ("Deflection, RMS error (mm)", "挠度均方根误差 (mm)"),
    "steel_truth_scale": ("Scale of the photo model (%)", "影像模型尺度误差 (%)"),
    "steel_truth_members": ("Rods found, missed, false", "杆件：找到、漏检、误检"),
    # Paper
    "steel_paper_caption": (
        "The paper's figures (Guo et al. 2021), another structure, as printed.",
        "论文结果（郭明等，2021），另一结构，按原文列出。",
    ),
    "steel_paper_ours": ("This run", "本次"),
    "steel_paper_theirs": ("Paper", "论文"),
    "steel_paper_stations": ("Stations", "测站数"),
    "steel_paper_registration": ("Registration", "配准精度"),
    "steel_paper_columns": ("Columns over the limit", "超限钢柱"),
    "steel_paper_range": ("Deviations (mm)", "偏差范围 (mm)"),
    "steel_paper_deflection": ("Deflection over span", "挠度与跨度之比"),
    "steel_paper_table1": ("The paper's Table 1.", "论文表 1。"),
    "steel_of": ("{part} of {whole}", "{whole} 根中 {part} 根"),
    "steel_paper_under": ("under 1/250", "小于 1/250"),
    "steel_leans_north": ("leans north {value}", "向北倾斜 {value}"),
    "steel_leans_east": ("leans east {value}", "向东倾斜 {value}"),
    "steel_leans_west": ("leans west {value}", "向西倾斜 {value}"),
    # Plots
    "plot_x_m": ("x (m)", "x (m)"),
    "plot_y_m": ("y (m)", "y (m)"),
    "plot_scan_station": ("station", "测站"),
    "plot_target": ("target", "靶标"),
    "plot_ellipse": ("standard deviation", "标准差椭圆"),
    "plot_residual": ("residual (mm)", "残差 (mm)"),
    "plot_count": ("observations", "观测数"),
    "plot_setups": ("set-ups away from the base", "距基站的设站次数"),
    "plot_off_place": ("off the adjusted place (mm)", "与平差位置之差 (mm)"),
    "plot_off_truth": ("off the true place (mm)", "与真实位置之差 (mm)"),
    "plot_off_fitted": ("after the best fit (mm)", "最佳拟合后之差 (mm)"),
    "plot_chained": ("station by station", "逐站配准"),
    "plot_icp": ("pairwise ICP", "逐对 ICP"),
    "plot_adjusted": ("adjusted together", "整体平差"),
    "plot_chained_sigma": ("predicted, station by station", "逐站配准预期 σ"),
    "plot_adjusted_sigma": ("predicted, adjusted", "整体平差预期 σ"),
    "plot_within": ("within the limit", "合格"),
    "plot_near": ("near the limit", "临界"),
    "plot_over": ("over the limit", "超限"),
    "plot_eccentric": ("eccentric", "偏心"),
    "plot_not_significant": ("not significant", "不显著"),
    "plot_eccentricity": ("eccentricity (mm)", "偏心量 (mm)"),
    "plot_nodes": ("nodes", "节点"),
    "plot_deflection": ("deflection (mm)", "挠度 (mm)"),
    "plot_limit": ("limit", "限值"),
    "plot_along": ("along the structure (m)", "沿结构方向 (m)"),
    "plot_support": ("support", "支座"),
    "plot_north": ("N", "北"),
    "plot_scale": ("scale", "比例"),
    # Times
    "stage_clouds": ("read clouds", "读取点云"),
    "stage_targets": ("find targets", "识别靶标"),
    "stage_features": ("find features", "提取特征"),
    "stage_naming": ("name targets", "靶标配对"),
    "stage_register": ("register", "整体配准"),
    "stage_chained": ("chain", "逐站配准"),
    "stage_icp": ("ICP", "ICP 配准"),
    "stage_compare": ("compare with chaining and ICP", "与逐站配准、ICP 比较"),
    "stage_tiles": ("tile the cloud", "点云分块"),
    "stage_members": ("fit members", "构件拟合"),
    "stage_nodes": ("judge nodes", "节点偏心"),
    "stage_columns": ("judge columns", "钢柱倾斜"),
    "stage_deflection": ("judge deflection", "挠度分析"),
    "stage_judge": ("judge nodes and columns", "节点与钢柱分析"),
    "stage_photos": ("photo model", "影像建模"),
    "stage_fuse": ("fuse photos", "影像融合"),
    # Files
    "file_stations.csv": ("stations with attitudes and σ", "测站位置、姿态与 σ"),
    "file_residuals.csv": ("residual of each observation", "各观测残差"),
    "file_nodes.csv": ("node eccentricity", "球节点偏心"),
    "file_columns.csv": ("column inclination (Table 1)", "钢柱倾斜（表 1）"),
    "file_deflection.csv": ("deflection of the nodes", "节点挠度"),
    "file_members.glb": ("fitted rods, balls, columns, arrows", "拟合的杆件、球、柱与箭头"),
    "file_members.ply": ("the same for point cloud programs", "同上，点云软件用"),
    "file_merged.ply": (
        "scans and photos in one cloud, each point with its origin",
        "扫描与影像合并点云，含来源",
    ),
    "steel_file_cloud": (
        "registered points, coloured by station",
        "配准点云，按测站着色",
    ),
    "steel_frame_control": (
        "Metres, z up. The site frame is that of the control targets; north lies {north}° clockwise from +y.",
        "单位米，z 轴向上。现场坐标系由控制靶标确定；北方向自 +y 顺时针 {north}°。",
    ),
    "steel_frame_base": (
        "Metres, z up. The site frame is that of station {name}; north lies {north}° clockwise from +y.",
        "单位米，z 轴向上。现场坐标系为测站 {name} 坐标系；北方向自 +y 顺时针 {north}°。",
    ),
}
