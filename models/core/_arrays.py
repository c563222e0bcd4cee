"""Names for the kinds of array that everything else passes on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Image = NDArray[np.uint8]
