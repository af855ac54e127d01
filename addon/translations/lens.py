"""The area *Lens*."""

ZH = {
    "Show Preview": "显示预览",
    "Show a frame before and after the correction, side by side in a window of their own": (
        "在单独的窗口中并排显示一帧影像校正前后的样子"
    ),
    "Estimate": "估计",
    "Estimate lambda from the edges of the cable in the block's video, in the background": (
        "在后台由该条带视频中的拉索边缘估计 λ"
    ),
    "All blocks": "所有条带",
    "Estimate the lambda of every block from its own video": "由各条带自己的视频估计其 λ",
    "Calibrate": "检校",
    "Find focal length, principal point and lambda from pictures of a chessboard": (
        "由棋盘格影像求焦距、像主点和 λ"
    ),
    "Give every block this lens: for cameras that are alike": "所有条带采用此镜头：用于相同的相机",
    "{}: lambda {:.5f} ± {:.5f}": "{}：λ = {:.5f} ± {:.5f}",
    "{} of {} pictures used, corners to {:.2f} px": "使用了 {} / {} 张影像，角点精度 {:.2f} px",
    "From the cable's edges": "由拉索边缘",
    "From a chessboard": "由棋盘格",
    "Estimated": "估计值",
    "Estimated in each run": "每次重建时估计",
    "Frame": "帧",
    "Number of the frame that is shown, from 0": "所显示帧的编号，从 0 起",
    "Frames in the video of the shown block": "当前条带视频的帧数",
    "Grid": "格网",
    "Draw a grid over the frame that is straight where no distortion is left": (
        "在影像上绘制格网，畸变消除后格网线为直线"
    ),
    "Cells": "格数",
    "Cells of the grid across the picture": "影像横向的格数",
    "Before": "校正前",
    "The frame as the camera took it": "相机拍摄的原始帧",
    "After": "校正后",
    "The frame without distortion": "去除畸变后的帧",
    "Why the preview does not follow, one sentence": "预览未更新的原因，一句话",
    "Pictures": "影像",
    "Folder of pictures of one chessboard, taken with this camera from different sides": (
        "用该相机从不同方向拍摄的同一棋盘格的影像文件夹"
    ),
    "Inner corners": "内角点数",
    "Inner corners of the board, along and across": "棋盘格的内角点数：横向与纵向",
    "Sigma of lambda": "λ 的中误差",
    "Standard deviation of lambda; 0 where none is stated: then it counts as a rough value": (
        "λ 的标准差；未给出时为 0，此时 λ 只作粗略初值"
    ),
    "Lambda from": "λ 来源",
    "Where lambda came from": "λ 的来源",
    "By hand": "手动",
    "Typed or read from the survey file": "手工输入或读自项目文件",
    "The cable's edges": "拉索边缘",
    "Estimated from this camera's own video": "由该相机自己的视频估计",
    "Chessboard": "棋盘格",
    "Calibrated from pictures of a chessboard": "由棋盘格影像检校",
}
