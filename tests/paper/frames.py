"""Hand-made claims and runs of a reproduction."""

import pandas as pd

CLAIMS = pd.DataFrame({
    "claim": ["it crawls", "it is fast", "it is slow", "it sings", "it is quiet"],
    "source": ["Fig. 1", "Fig. 2", "Fig. 3", "Fig. 4", "Fig. 5"],
    "paper": ["yes", 0.0056, "> 0", 33, "not given"],
    "ours": [1.0, 0.0049321, -0.5, float("nan"), 123.4],
    "low": [0.7, 0.0045, -0.5, float("nan"), 120.2],
    "high": [1.0, 0.0052, -0.5, float("nan"), 130.7],
    "n": [10, 10, 1, 0, 10],
    "verdict": ["reproduced", "partly", "not reproduced", "no data", "no number given"],
})  # fmt: skip
RUNS = pd.DataFrame({
    "experiment": ["regularized", "unregularized", "untrained"],
    "seed": [0, 1, 2],
    "policy": ["0123456789", "7207345679", "**********"],
    "speed": [0.0054321, 0.0061234, 0.001],
    "speed_moving": [0.0054321, float("nan"), 0.001],
    "stall_share": [0.0, 0.25, 0.0],
    "cycle_duration": [38.25, 26.0, float("nan")],
    "run": ["a", "b", "c"],
})  # fmt: skip
