"""Check of a track against the frames, by means that did not make it."""

from servosight.tracking.verification._moving import (
    sampled_where_it_moves as sampled_where_it_moves,
)
from servosight.tracking.verification._sample import FrameSample as FrameSample
from servosight.tracking.verification._sample import at_scale as at_scale
from servosight.tracking.verification._sample import small as small
from servosight.tracking.verification._scene import TurningScene as TurningScene
from servosight.tracking.verification._turning import Gains as Gains
from servosight.tracking.verification._turning import PolarView as PolarView
from servosight.tracking.verification._turning import grown_round as grown_round
from servosight.tracking.verification._turning import rows_of as rows_of
from servosight.tracking.verification._verify import Evidence as Evidence
from servosight.tracking.verification._verify import VerificationLimits as VerificationLimits
from servosight.tracking.verification._verify import contradiction as contradiction
from servosight.tracking.verification._verify import evidence_of as evidence_of
