"""The camera's own motion, and frames brought to its rest."""

from servosight.tracking.composite.camera._camera import CameraPath as CameraPath
from servosight.tracking.composite.camera._camera import aligned as aligned
from servosight.tracking.composite.camera._camera import displacement_px as displacement_px
from servosight.tracking.composite.camera._camera import motion_from as motion_from
from servosight.tracking.composite.camera._camera import refined as refined
from servosight.tracking.composite.camera._direct import Background as Background
