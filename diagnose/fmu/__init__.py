"""Comparison and diagnosis of a model that is an FMU."""

from servosight.diagnose.fmu._compare_fmu import compare_fmu as compare_fmu
from servosight.diagnose.fmu._diagnose_fmu import diagnose_fmu as diagnose_fmu
