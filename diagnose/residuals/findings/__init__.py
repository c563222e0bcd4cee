"""Findings: what the error of a model depends on, one test a finding."""

from servosight.diagnose.residuals.findings._finding import Finding as Finding
from servosight.diagnose.residuals.findings._finding import listed as listed
from servosight.diagnose.residuals.findings._finding import phrased as phrased
from servosight.diagnose.residuals.findings._findings import CHANCE as CHANCE
from servosight.diagnose.residuals.findings._findings import findings as findings
from servosight.diagnose.residuals.findings._findings import lead as lead
