"""What a physical effect is, and the registry of all of them."""

from servosight.models.effects._check import parsed as parsed
from servosight.models.effects._contract import Effect as Effect
from servosight.models.effects._contract import GuessFeatures as GuessFeatures
from servosight.models.effects._contract import Usual as Usual
from servosight.models.effects._info import EffectInfo as EffectInfo
from servosight.models.effects._info import EffectTable as EffectTable
from servosight.models.effects._info import effect_info as effect_info
from servosight.models.effects._initial_guess import ResidualFeatures as ResidualFeatures
from servosight.models.effects._place import SIGNATURES as SIGNATURES
from servosight.models.effects._place import Place as Place
from servosight.models.effects._registry import catalogue as catalogue
from servosight.models.effects._registry import covered as covered
from servosight.models.effects._registry import select as select
