"""What is done on the bench: a run, from the first frame to the recording's folder."""

from servosight.bench.session._check import CheckLimits as CheckLimits
from servosight.bench.session._check import MeasuredRate as MeasuredRate
from servosight.bench.session._check import check_camera as check_camera
from servosight.bench.session._check import check_servo as check_servo
from servosight.bench.session._check import judge_pictures as judge_pictures
from servosight.bench.session._check import judge_rate as judge_rate
from servosight.bench.session._check import measure_camera as measure_camera
from servosight.bench.session._check import reading_words as reading_words
from servosight.bench.session._check import serial_ports as serial_ports
from servosight.bench.session._lines import Line as Line
from servosight.bench.session._run import Light as Light
from servosight.bench.session._run import Run as Run
from servosight.bench.session._run import run as run
from servosight.bench.session._run import run_words as run_words
from servosight.bench.session._surface import SurfaceLimits as SurfaceLimits
from servosight.bench.session._surface import check_surface as check_surface
from servosight.bench.session._surface import judge_surface as judge_surface
from servosight.bench.session._write import RUN_FILES as RUN_FILES
