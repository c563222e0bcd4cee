"""The bench rehearsed without hardware: the twin behind a virtual servo and a virtual camera."""

from servosight.scenarios.rehearsal._bench import CAMERA as CAMERA
from servosight.scenarios.rehearsal._bench import HIDDEN as HIDDEN
from servosight.scenarios.rehearsal._bench import Rehearsal as Rehearsal
from servosight.scenarios.rehearsal._bench import VirtualBench as VirtualBench
from servosight.scenarios.rehearsal._bench import served_bench as served_bench
from servosight.scenarios.rehearsal._bench import virtual_bench as virtual_bench
from servosight.scenarios.rehearsal._camera import CameraFaults as CameraFaults
from servosight.scenarios.rehearsal._rehearse import rehearse as rehearse
from servosight.scenarios.rehearsal._rehearse import write_truth as write_truth
