"""Cameras: one small protocol, the back ends behind it, and the recorder."""

from servosight.bench.camera._found import FoundCamera as FoundCamera
from servosight.bench.camera._jpeg import jpeg_size as jpeg_size
from servosight.bench.camera._protocol import CameraLost as CameraLost
from servosight.bench.camera._protocol import CapturedFrame as CapturedFrame
from servosight.bench.camera._protocol import Given as Given
from servosight.bench.camera._protocol import OpenCamera as OpenCamera
from servosight.bench.camera._protocol import Stream as Stream
from servosight.bench.camera._recorder import VIDEO as VIDEO
from servosight.bench.camera._recorder import Footage as Footage
from servosight.bench.camera._recorder import Recorder as Recorder
from servosight.bench.camera._registry import list_cameras as list_cameras
from servosight.bench.camera._registry import open_camera as open_camera
