"""The difference equation, and distortion without a model."""

from servosight.identify.discrete._discrete import Difference as Difference
from servosight.identify.discrete._discrete import Linear as Linear
from servosight.identify.discrete._discrete import to_difference as to_difference
from servosight.identify.discrete._distortion import Distortion as Distortion
from servosight.identify.discrete._distortion import distortion as distortion
