"""Hidden effects of the twin, by MuJoCo's own means."""

from servosight.sim.effects._contract import EffectValues as EffectValues
from servosight.sim.effects._contract import HiddenEffect as HiddenEffect
from servosight.sim.effects._contract import Polyline as Polyline
from servosight.sim.effects._contract import Twin as Twin
from servosight.sim.effects._registry import HIDDEN_EFFECTS as HIDDEN_EFFECTS
from servosight.sim.effects._registry import TWIN_EFFECTS as TWIN_EFFECTS
from servosight.sim.effects._registry import resolve as resolve
