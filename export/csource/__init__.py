"""The plant step of a model as C99: the kernel's own functions, printed."""

from servosight.export.csource._compile import compile_c as compile_c
from servosight.export.csource._compile import missing as missing
from servosight.export.csource._exporter import C as C
from servosight.export.csource._model import layout_of as layout_of
from servosight.export.csource._model import limits_of as limits_of
from servosight.export.csource._model import model_source as model_source
from servosight.export.csource._model import parameters_of as parameters_of
from servosight.export.csource._model import values_of as values_of
from servosight.export.csource._reference import HeldSteps as HeldSteps
from servosight.export.csource._reference import check_equal as check_equal
from servosight.export.csource._reference import held_steps as held_steps
from servosight.export.csource._reference import kernel_angle as kernel_angle
