"""Recordings and settings in and out of files, written completely or not at all."""

from servosight.models.io._csv import Sheet as Sheet
from servosight.models.io._csv import read_sheet as read_sheet
from servosight.models.io._csv import table_text as table_text
from servosight.models.io._in_memory import recording_from_arrays as recording_from_arrays
from servosight.models.io._in_memory import recording_from_frame as recording_from_frame
from servosight.models.io._recording import EXPOSURE_SHARE as EXPOSURE_SHARE
from servosight.models.io._recording import RecordingFolder as RecordingFolder
from servosight.models.io._recording import inspect_folder as inspect_folder
from servosight.models.io._recording import load_recording as load_recording
from servosight.models.io._save import FILES as FILES
from servosight.models.io._save import angle_text as angle_text
from servosight.models.io._save import save_recording as save_recording
from servosight.models.io._save import write_angle as write_angle
from servosight.models.io._series import SECONDS as SECONDS
from servosight.models.io._series import Series as Series
from servosight.models.io._series import check_angle as check_angle
from servosight.models.io._series import check_finite as check_finite
from servosight.models.io._series import check_time as check_time
from servosight.models.io._settings import LONGEST_EXPOSURE_S as LONGEST_EXPOSURE_S
from servosight.models.io._settings import set_keys as set_keys
from servosight.models.io._shared_error import NAME as NAME
from servosight.models.io._shared_error import write_shared as write_shared
