"""Horn, pushrod and surface in one view: which part is which, and the rod between them."""

from servosight.tracking.linkage._find import find_linkage as find_linkage
from servosight.tracking.linkage._find import linked as linked
