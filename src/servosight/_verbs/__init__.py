"""The verbs of ``import servosight as ss``: thin, and each with its defaults.

A recording is given as a ``Recording`` or as the path of one; several as a sequence of either, or
as one. What a verb needs is imported when it is called.
"""

from servosight._verbs import bench as bench
from servosight._verbs._catalogue import effects as effects
from servosight._verbs._catalogue import load as load
from servosight._verbs._compare import compare as compare
from servosight._verbs._export import export as export
from servosight._verbs._models import add as add
from servosight._verbs._models import diagnose as diagnose
from servosight._verbs._models import identify as identify
from servosight._verbs._models import predict as predict
from servosight._verbs._recordings import read as read
from servosight._verbs._recordings import simulate as simulate
from servosight._verbs._recordings import track as track
from servosight._verbs._sweeps import results as results
from servosight._verbs._sweeps import sweep as sweep
