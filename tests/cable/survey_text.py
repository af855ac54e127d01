"""The survey.toml of the contract, and a second camera for it."""

CONTRACT = """
format = 1
name = "stay-07"

[cable]
travel_m = 0.46
diameter_mm = 110.0
[[cable.station]]
name = "A"
position_m = 0.10

[robot]
standoff_m = 0.30
synchronised = true

[[block]]
name = "Block1"
source = "block1.mp4"
angle_deg = 0.0
travel_in_image = "right"
pos = "block1_pos.csv"
[block.lens]
focal_px = 720.0
principal_point_px = [480.0, 300.0]
division_lambda = -0.02
lambda_radius = "half-diagonal"
calibrated = false
"""

SECOND_BLOCK = """
[[block]]
name = "Block2"
source = "block1.mp4"
angle_deg = 90
travel_in_image = "up"
[block.lens]
focal_mm = 4.5
sensor_width_mm = 6.0
"""
