"""What the rows of a sweep say: tables by axis, detection by size, and what to buy."""

from servosight.scenarios.sweeps.answers._advice import SHIPPED as SHIPPED
from servosight.scenarios.sweeps.answers._advice import Advice as Advice
from servosight.scenarios.sweeps.answers._advice import advise as advise
from servosight.scenarios.sweeps.answers._advice import saved_answers as saved_answers
from servosight.scenarios.sweeps.answers._detection import Detection as Detection
from servosight.scenarios.sweeps.answers._detection import detection as detection
from servosight.scenarios.sweeps.answers._detection import share_at as share_at
from servosight.scenarios.sweeps.answers._found import Found as Found
from servosight.scenarios.sweeps.answers._found import value_text as value_text
from servosight.scenarios.sweeps.answers._summary import Summary as Summary
from servosight.scenarios.sweeps.answers._summary import summary as summary
