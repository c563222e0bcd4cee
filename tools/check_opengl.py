"""Render one triangle without a screen; exit 1 with one sentence when that does not work."""

from __future__ import annotations

import os
import sys
import warnings

os.environ["PYOPENGL_PLATFORM"] = "egl"


def main() -> int:
    """Draw a white triangle on black through EGL and look at the picture."""
    warnings.simplefilter("ignore")
    try:
        import numpy as np
        import pyrender

        corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]
        scene = pyrender.Scene(bg_color=[0, 0, 0, 255], ambient_light=[1.0, 1.0, 1.0])
        scene.add(pyrender.Mesh([pyrender.Primitive(positions=np.array(corners, np.float32))]))
        pose = np.eye(4)
        pose[2, 3] = 2.0
        scene.add(pyrender.PerspectiveCamera(yfov=1.0), pose=pose)
        renderer = pyrender.OffscreenRenderer(64, 48)
        try:
            color, _ = renderer.render(scene)
        finally:
            renderer.delete()
    except Exception as problem:  # whatever is missing shows up in its own way
        print(f"no OpenGL without a screen: {problem!r}", file=sys.stderr)
        return 1
    if color[24, 32].max() < 100 or color[0, 0].max() > 10:
        print("OpenGL answers, but the picture it draws is wrong", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
