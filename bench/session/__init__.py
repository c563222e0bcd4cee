"""What is done on the bench: a run, from the first frame to the recording's folder."""

from servosight.bench.session._run import Light as Light
from servosight.bench.session._run import Run as Run
from servosight.bench.session._run import run as run
from servosight.bench.session._write import RUN_FILES as RUN_FILES
from servosight.bench.session._write import SIGN as SIGN
from servosight.bench.session._write import Clocked as Clocked
