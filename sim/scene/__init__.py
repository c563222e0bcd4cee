"""The bench as a camera sees it: parts, shapes and textures."""

from servosight.sim.scene._cover import CARD_HEIGHT_MM as CARD_HEIGHT_MM
from servosight.sim.scene._cover import Cover as Cover
from servosight.sim.scene._cover import card as card
from servosight.sim.scene._scene import ARM_TOP_MM as ARM_TOP_MM
from servosight.sim.scene._scene import FIN as FIN
from servosight.sim.scene._scene import FIN_RADIUS_MM as FIN_RADIUS_MM
from servosight.sim.scene._scene import LED_MM as LED_MM
from servosight.sim.scene._scene import LED_RADIUS_MM as LED_RADIUS_MM
from servosight.sim.scene._scene import LENS_HEIGHT_MM as LENS_HEIGHT_MM
from servosight.sim.scene._scene import LUGS_MM as LUGS_MM
from servosight.sim.scene._scene import PLATE_Z_MM as PLATE_Z_MM
from servosight.sim.scene._scene import MovingBody as MovingBody
from servosight.sim.scene._scene import Viewport as Viewport
from servosight.sim.scene._scene import arm_of as arm_of
from servosight.sim.scene._scene import case_meshes as case_meshes
from servosight.sim.scene._scene import rod_of as rod_of
from servosight.sim.scene._scene import table as table
