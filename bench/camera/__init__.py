"""Cameras: one small protocol, and what stands behind it."""

from servosight.bench.camera._protocol import Camera as Camera
