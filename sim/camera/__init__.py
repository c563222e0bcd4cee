"""From the scene to an exposed picture: rendering, lens, light and sensor."""

from servosight.sim.camera._compose import TRIPOD as TRIPOD
from servosight.sim.camera._compose import Plane as Plane
from servosight.sim.camera._compose import Pose as Pose
from servosight.sim.camera._compose import led_of as led_of
from servosight.sim.camera._compose import light_of as light_of
from servosight.sim.camera._lens import Lens as Lens
from servosight.sim.camera._optics import FixedPattern as FixedPattern
from servosight.sim.camera._optics import Light as Light
from servosight.sim.camera._optics import Optics as Optics
from servosight.sim.camera._optics import expose as expose
from servosight.sim.camera._optics import fixed_pattern as fixed_pattern
from servosight.sim.camera._optics import vignette as vignette
from servosight.sim.camera._projection import Sight as Sight
from servosight.sim.camera._projection import folds as folds
from servosight.sim.camera._props import props as props
from servosight.sim.camera._render import ROOM_PX as ROOM_PX
from servosight.sim.camera._render import Layers as Layers
from servosight.sim.camera._render import render_layers as render_layers
