"""What the program prints and writes: results in words, JSON, files, notes and progress.

Loads neither numbers nor rich until something is shown.
"""

from servosight.app.terminal._change import show_change as show_change
from servosight.app.terminal._output import check_outputs as check_outputs
from servosight.app.terminal._output import check_target as check_target
from servosight.app.terminal._output import console as console
from servosight.app.terminal._output import ignore_closed_pipe as ignore_closed_pipe
from servosight.app.terminal._output import made as made
from servosight.app.terminal._output import next_command as next_command
from servosight.app.terminal._output import show_notes as show_notes
from servosight.app.terminal._output import write_json as write_json
from servosight.app.terminal._progress import Shown as Shown
from servosight.app.terminal._progress import progress as progress
from servosight.app.terminal._progress import quiet as quiet
from servosight.app.terminal._progress import set_amount as set_amount
from servosight.app.terminal._results import show_diagnosis as show_diagnosis
from servosight.app.terminal._results import show_findings as show_findings
from servosight.app.terminal._results import show_fit as show_fit
from servosight.app.terminal._results import show_identification as show_identification
from servosight.app.terminal._results import show_parameters as show_parameters
from servosight.app.terminal._results import show_where as show_where
