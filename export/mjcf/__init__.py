"""The servo as a MuJoCo model, and as a joint in URDF, which MuJoCo reads too, and in SDF."""

from servosight.export.mjcf._mjcf import MJCF as MJCF
from servosight.export.mjcf._sdf import SDF as SDF
from servosight.export.mjcf._urdf import URDF as URDF
