"""Parts of which nothing is known, and what enters a picture beside them."""

from servosight.tracking.composite.parts._colour import colour_of as colour_of
from servosight.tracking.composite.parts._entering import enough_left as enough_left
from servosight.tracking.composite.parts._entering import entering as entering
from servosight.tracking.composite.parts._entering import without_entering as without_entering
from servosight.tracking.composite.parts._part import Change as Change
from servosight.tracking.composite.parts._part import Reference as Reference
from servosight.tracking.composite.parts._part import TurningPart as TurningPart
from servosight.tracking.composite.parts._part import diverse as diverse
from servosight.tracking.composite.parts._part import learnt as learnt
from servosight.tracking.composite.parts._part import pieces_of as pieces_of
from servosight.tracking.composite.parts._part import pivot_scores as pivot_scores
from servosight.tracking.composite.parts._part import references_of as references_of
from servosight.tracking.composite.parts._shadow import Shadow as Shadow
