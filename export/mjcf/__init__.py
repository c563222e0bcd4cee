"""The servo as a MuJoCo model."""

from servosight.export.mjcf._mjcf import MJCF as MJCF
