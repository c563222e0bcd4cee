"""Command signals, and their design within limits."""

from servosight.models.excitation._design import SHAPES as SHAPES
from servosight.models.excitation._design import Design as Design
from servosight.models.excitation._design import Form as Form
from servosight.models.excitation._design import design as design
from servosight.models.excitation._design import slewed as slewed
from servosight.models.excitation._limits import CommandLimits as CommandLimits
from servosight.models.excitation._multisine import Grid as Grid
from servosight.models.excitation._multisine import grid_of as grid_of
from servosight.models.excitation._shapes import Excitation as Excitation
from servosight.models.excitation._shapes import chirp as chirp
from servosight.models.excitation._shapes import multisine as multisine
from servosight.models.excitation._shapes import sine as sine
from servosight.models.excitation._shapes import standard as standard
from servosight.models.excitation._shapes import steps as steps
from servosight.models.excitation._shapes import triangle as triangle
