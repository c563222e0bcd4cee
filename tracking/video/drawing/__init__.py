"""Drawing the result on the video's pictures."""

from servosight.tracking.video.drawing._draw import write_overlay as write_overlay
from servosight.tracking.video.drawing._draw import write_picture as write_picture
from servosight.tracking.video.drawing._draw import write_sheet as write_sheet
from servosight.tracking.video.drawing._refused import SeenPart as SeenPart
from servosight.tracking.video.drawing._refused import refusal_picture as refusal_picture
