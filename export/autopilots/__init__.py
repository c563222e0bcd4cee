"""Flight simulators, whose actuators have a rate limit, a delay and play in series."""

from servosight.export.autopilots._ardupilot import ARDUPILOT as ARDUPILOT
from servosight.export.autopilots._jsbsim import JSBSIM as JSBSIM
