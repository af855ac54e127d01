"""A survey of drawn pictures, ready at once: two blocks of a cable through a lens with lambda -0.04."""

import cv2

FRAMES = 9
SURVEY = """
format = 1
name = "drawn"
[cable]
travel_m = 0.12
diameter_mm = 110.0
[robot]
standoff_m = 0.30
synchronised = true
[[block]]
name = "Block1"
source = "block1.avi"
angle_deg = 0.0
travel_in_image = "right"
[block.lens]
focal_px = 720.0
division_lambda = -0.1
[[block]]
name = "Block2"
source = "block2"
angle_deg = 90.0
travel_in_image = "right"
[block.lens]
focal_px = 720.0
"""


def draw(folder):
    """A video and a folder of images with their survey.toml; gives its path."""
    # not before the extension is enabled: a test looks at what that loads
    from tests.cable.outline_pictures import picture_of_cable
    from tests.cable.test_lens import TOUCH, bent

    (folder / "block2").mkdir(parents=True)
    video = cv2.VideoWriter(str(folder / "block1.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 10, (960, 600))
    for k in range(FRAMES):
        picture = picture_of_cable(bent(-TOUCH), bent(TOUCH), seed=k)
        video.write(picture)
        cv2.imwrite(str(folder / "block2" / f"img{k}.png"), picture)
    video.release()
    (folder / "survey.toml").write_text(SURVEY, encoding="utf-8")
    return folder / "survey.toml"
