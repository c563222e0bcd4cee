"""The difference equation, and distortion without a model."""

from servosight.identify.discrete._distortion import Distortion as Distortion
from servosight.identify.discrete._distortion import distortion as distortion
