"""The figures of the reproduction, one function each: records, arrays and tables in, a Matplotlib figure out.

Only `save` writes files; no figure calls the simulator.
"""

from matplotlib.figure import Figure

from crawler_bench.output.kymographs import gait, untrained
from crawler_bench.output.style import save
from crawler_bench.paper.figure_1 import fig_1a
from crawler_bench.paper.figure_2 import learning, policies
from crawler_bench.paper.figure_3 import cycle_durations, power_by_phase, speed_against_noise

__all__ = [
    "Figure",
    "cycle_durations",
    "fig_1a",
    "gait",
    "learning",
    "policies",
    "power_by_phase",
    "save",
    "speed_against_noise",
    "untrained",
]
