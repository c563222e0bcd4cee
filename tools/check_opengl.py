"""Check that OpenGL renders without a screen.

    python3 tools/check_opengl.py --libraries   # standard library only: what the system lacks
    .venv/bin/python tools/check_opengl.py      # render one triangle with what the program uses

With ``--libraries`` the Debian packages that are missing go to standard output, one a line.
Exit code 1 with one sentence on standard error when something is missing or does not work.
"""

from __future__ import annotations

import ctypes
import os
import sys
import warnings

# Library -> the package of Debian and Ubuntu that has it. pyrender and pyglet load both by name, so
# that ldd does not show them; without libGL the first call fails with "no attribute 'glGetError'".
LIBRARIES = {"libEGL.so.1": "libegl1", "libGL.so.1": "libgl1"}
DRIVERS = "libgl1-mesa-dri"
EGL_PLATFORM_DEVICE_EXT = 0x313F


def missing_packages() -> dict[str, str]:
    """What the system lacks for OpenGL without a screen: package -> reason."""
    missing: dict[str, str] = {}
    for library, package in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing[package] = f"{library} is not there"
    if "libegl1" in missing:
        missing[DRIVERS] = "no driver can be loaded without libEGL"
    elif not driver_answers():
        missing[DRIVERS] = "libEGL finds no driver that works without a screen"
    return missing


def driver_answers() -> bool:
    """Whether the first EGL device can be initialised, as pyrender and MuJoCo do it."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    query = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    get_display = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query or not get_display:
        return False
    device, count = ctypes.c_void_p(), ctypes.c_int()
    pointer, integer = ctypes.c_void_p, ctypes.c_int
    query_devices = ctypes.CFUNCTYPE(integer, integer, pointer, pointer)(query)
    if not query_devices(1, ctypes.byref(device), ctypes.byref(count)) or count.value < 1:
        return False
    platform_display = ctypes.CFUNCTYPE(pointer, integer, pointer, pointer)(get_display)
    display = platform_display(EGL_PLATFORM_DEVICE_EXT, device, None)
    egl.eglInitialize.argtypes = [pointer, pointer, pointer]
    egl.eglTerminate.argtypes = [pointer]
    if not display or not egl.eglInitialize(display, None, None):
        return False
    egl.eglTerminate(display)
    return True


def render_triangle() -> str | None:
    """Draw a white triangle on black; what went wrong, or None."""
    os.environ["PYOPENGL_PLATFORM"] = "egl"
    os.environ["PYGLET_HEADLESS"] = "1"  # as in sim: no X libraries
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
    except Exception as problem:  # every missing part fails in its own way
        return f"OpenGL does not render without a screen: {problem!r}"
    if color[24, 32].max() < 100 or color[0, 0].max() > 10:
        return "OpenGL renders without a screen, but the picture is wrong"
    return None


def main(arguments: list[str]) -> int:
    """Check the libraries and, unless ``--libraries`` is given, the rendering."""
    missing = missing_packages()
    if missing:
        reasons = "; ".join(dict.fromkeys(missing.values()))
        print(f"OpenGL without a screen is incomplete: {reasons}", file=sys.stderr)
        if "--libraries" in arguments:
            print("\n".join(missing))
        return 1
    if "--libraries" in arguments:
        return 0
    problem = render_triangle()
    if problem:
        print(problem, file=sys.stderr)
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
