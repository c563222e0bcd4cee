"""The linear core for python-control."""

from servosight.export.linear._control import CONTROL as CONTROL
