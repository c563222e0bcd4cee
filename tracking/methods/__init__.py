"""Ways to measure the angle: refine, match, markers."""

from servosight.tracking.methods._markers import Family as Family
from servosight.tracking.methods._markers import track_marker as track_marker
from servosight.tracking.methods._match import Match as Match
from servosight.tracking.methods._match import choose_box as choose_box
from servosight.tracking.methods._refine import Refine as Refine
from servosight.tracking.methods._refine import likely as likely
