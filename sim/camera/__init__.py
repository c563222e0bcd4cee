"""From the scene to an exposed picture: rendering, lens, light and sensor."""

from servosight.sim.camera._compose import TRIPOD as TRIPOD
from servosight.sim.camera._compose import MonoScene as MonoScene
from servosight.sim.camera._compose import Pose as Pose
from servosight.sim.camera._compose import led_of as led_of
from servosight.sim.camera._compose import light_of as light_of
from servosight.sim.camera._lens import TiltedLens as TiltedLens
from servosight.sim.camera._lighting import Lighting as Lighting
from servosight.sim.camera._optics import FixedPattern as FixedPattern
from servosight.sim.camera._optics import Optics as Optics
from servosight.sim.camera._optics import expose as expose
from servosight.sim.camera._optics import fixed_pattern as fixed_pattern
from servosight.sim.camera._optics import vignette as vignette
from servosight.sim.camera._overlays import overlays as overlays
from servosight.sim.camera._projection import Projection as Projection
from servosight.sim.camera._projection import folds as folds
from servosight.sim.camera._render import ROOM_PX as ROOM_PX
from servosight.sim.camera._render import BenchLayers as BenchLayers
from servosight.sim.camera._render import render_layers as render_layers
