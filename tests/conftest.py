"""What all tests share: no screen, one thread a worker, the place of real servos' recordings."""

from __future__ import annotations

import os
import pty
from pathlib import Path

# Before anything imports OpenGL, MuJoCo, matplotlib or numpy: they read these once.
os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
os.environ.setdefault("MUJOCO_GL", "egl")
os.environ.setdefault("MPLBACKEND", "Agg")
# Tests run in several processes already, in which more threads only wait for one another.
for _pool in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_pool, "1")

import pytest
from hypothesis import HealthCheck, settings

# The same examples in every run: a failure that comes and goes helps nobody.
settings.register_profile(
    "servosight",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("servosight")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip what needs pseudo-terminals where there are none, as in a chroot without devpts."""
    try:
        ends = pty.openpty()
    except OSError:
        skip = pytest.mark.skip(reason="this machine has no pseudo-terminals")
        for item in items:
            if item.get_closest_marker("pty"):
                item.add_marker(skip)
    else:
        for end in ends:
            os.close(end)


@pytest.fixture(scope="session")
def project_root() -> Path:
    """The folder that holds pyproject.toml."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder with recordings of real servos that SERVOSIGHT_DATA names; skips without it."""
    place = os.environ.get("SERVOSIGHT_DATA", "")
    if not place or not Path(place).is_dir():
        pytest.skip("SERVOSIGHT_DATA names no folder")
    return Path(place)
