"""The whole model as an FMU of FMI 2.0 or 3.0."""

from servosight.export.fmu._exporter import FMU2 as FMU2
from servosight.export.fmu._exporter import FMU3 as FMU3
