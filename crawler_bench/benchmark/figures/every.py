"""The figures of a benchmark, one function each: the frames of `Benchmark` in, a Matplotlib figure out.

Only `save` writes files; no figure calls the simulator.
"""

from crawler_bench.benchmark.figures.curves import learning_curves, noise_curves, softening
from crawler_bench.benchmark.figures.policies import gaits, policy_matrices, trap_matrix
from crawler_bench.benchmark.figures.scores import cycle_durations, speeds
from crawler_bench.output.style import save

__all__ = [
    "cycle_durations",
    "gaits",
    "learning_curves",
    "noise_curves",
    "policy_matrices",
    "save",
    "softening",
    "speeds",
    "trap_matrix",
]
