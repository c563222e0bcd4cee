"""USB cameras on Linux, by Video4Linux."""

from servosight.bench.camera.v4l2._camera import open_v4l2 as open_v4l2
from servosight.bench.camera.v4l2._list import list_v4l2 as list_v4l2
