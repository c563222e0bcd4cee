"""From the effects' equations to one compiled function: printed, joined to an integrator, kept."""

from servosight.models.plant.kernel._codegen import kernel as kernel
from servosight.models.plant.kernel._codegen import kernel_source as kernel_source
from servosight.models.plant.kernel._codegen import not_compiled as not_compiled
from servosight.models.plant.kernel._layout import Layout as Layout
