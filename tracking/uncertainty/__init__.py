"""Sigma of each angle, and what widens it."""

from servosight.tracking.uncertainty._flicker import light_centre as light_centre
from servosight.tracking.uncertainty._sigma import columns as columns
from servosight.tracking.uncertainty._sigma import flags_of as flags_of
from servosight.tracking.uncertainty._sigma import gaps as gaps
from servosight.tracking.uncertainty._sigma import scatter as scatter
from servosight.tracking.uncertainty._sigma import shown_share as shown_share
from servosight.tracking.uncertainty._sigma import speeds as speeds
from servosight.tracking.uncertainty._sigma import uneven as uneven
