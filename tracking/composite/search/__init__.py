"""From pictures of a camera at rest to the part that turns in them."""

from servosight.tracking.composite.search._search import CLICKED as CLICKED
from servosight.tracking.composite.search._search import FoundPart as FoundPart
from servosight.tracking.composite.search._search import find_parts as find_parts
from servosight.tracking.composite.search._search import found_about as found_about
from servosight.tracking.composite.search._search import parts_otherwise as parts_otherwise
