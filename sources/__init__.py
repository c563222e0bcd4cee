"""From a path, a video or a log to a recording."""

from servosight.sources._clock import Offset as Offset
from servosight.sources._clock import known_camera as known_camera
from servosight.sources._clock import video_offset as video_offset
from servosight.sources._command import is_command as is_command
from servosight.sources._command import to_predict as to_predict
from servosight.sources._film import HORN as HORN
from servosight.sources._film import Part as Part
from servosight.sources._film import Parts as Parts
from servosight.sources._film import Tracking as Tracking
from servosight.sources._film import follow_folder as follow_folder
from servosight.sources._film import measured as measured
from servosight.sources._film import track_folder as track_folder
from servosight.sources._film import track_video as track_video
from servosight.sources._film import video_of as video_of
from servosight.sources._read import Options as Options
from servosight.sources._read import Source as Source
from servosight.sources._read import read as read
from servosight.sources._read import read_all as read_all
from servosight.sources._read import read_log as read_log
from servosight.sources._read import recordings_in as recordings_in
from servosight.sources._read import unit_hint as unit_hint
from servosight.sources._surface import TRACK_FILE as TRACK_FILE
from servosight.sources._surface import Geometry as Geometry
from servosight.sources._surface import digest as digest
from servosight.sources._surface import geometry_of as geometry_of
from servosight.sources._surface import tracked_files as tracked_files
