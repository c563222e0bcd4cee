"""Surface, its transparency and the background as layers, learnt from the video."""

from servosight.tracking.appearance.layers._fine import LayerEstimator as LayerEstimator
from servosight.tracking.appearance.layers._learn import layer_estimator as layer_estimator
