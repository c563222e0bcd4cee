"""The bench as a MuJoCo model, and what it did."""

from servosight.sim.bench._bench import HARD_IMPEDANCE as HARD_IMPEDANCE
from servosight.sim.bench._bench import LONGEST_STEP_S as LONGEST_STEP_S
from servosight.sim.bench._bench import SHORTEST_T_S as SHORTEST_T_S
from servosight.sim.bench._bench import STEPS_PER_T as STEPS_PER_T
from servosight.sim.bench._bench import STRONG_NM as STRONG_NM
from servosight.sim.bench._bench import Assembly as Assembly
from servosight.sim.bench._bench import BenchParameters as BenchParameters
from servosight.sim.bench._bench import assemble as assemble
from servosight.sim.bench._bench import linear as linear
from servosight.sim.bench._bench import link as link
from servosight.sim.bench._trajectory import GRID_S as GRID_S
from servosight.sim.bench._trajectory import Trajectory as Trajectory
