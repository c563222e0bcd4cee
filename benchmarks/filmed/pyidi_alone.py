"""Rigid image correlation by ``pyidi``, in an environment of its own: its OpenCV collides.

``frames.npz`` in, ``found.npz`` out: the shift of one square of the surface in every frame.
"""

import sys
import tempfile
import time

import numpy as np
from pyidi import VideoReader
from pyidi.methods import DIC

given = np.load(sys.argv[1])
with tempfile.TemporaryDirectory() as folder:
    video = VideoReader(given["pictures"], root=folder)
    method = DIC(video)
    method.set_points([given["centre_px"][::-1]])
    side = int(given["side_px"]) // 2 * 2 + 1
    start = time.process_time()
    shift = method.get_displacements(
        autosave=False, roi_size=(side, side), warp="rigid", verbose=0, show_pbar=False
    )
    np.savez(sys.argv[2], shift_px=shift[0, :, ::-1], seconds=time.process_time() - start)
