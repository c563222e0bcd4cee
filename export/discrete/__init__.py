"""The difference equation at a sample time: as a table, and as a C header."""

from servosight.export.discrete._csv import CSV as CSV
from servosight.export.discrete._header import HEADER as HEADER
