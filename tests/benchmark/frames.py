"""Hand-made frames of a benchmark."""

import pandas as pd

KEY = ["agent", "mode", "regularization", "seed"]
NAN = float("nan")


def run(agent="a", regularization=0.0, seed=0, mode="deterministic", **values):
    """A row of the runs; what is not said is the same for all."""
    known = {
        "policy": "0123456789", "off_diagonal": 0.5, "speed": 1.0, "speed_moving": 1.0, "reward": 1.0,
        "stall_share": 0.0, "decisions": 0, "gradient_updates": 0, "speed_learning_end": NAN, "cycles": 5,
        "cycle_duration": 40.0, "wave_order": 0.7, "peak_contraction": 0.3, "strain_gradient": 0.2,
        "unused_muscles": 0.0, "power_per_distance": 7.0,
    }  # fmt: skip
    key = {"agent": agent, "mode": mode, "regularization": regularization, "seed": seed}
    return key | known | values


def runs_of(agent, column, values, **more):
    """Runs with the seeds 0, 1, ... that differ in one column."""
    return [run(agent, seed=seed, **{column: value}, **more) for seed, value in enumerate(values)]


def evaluated(runs, speeds=None, starts=1):
    """Evaluations of runs; without speeds by amplitude each keeps its own speed under noise 0 and 0.4.

    Args:
        runs: rows.
        speeds: agent -> {amplitude: speed}.
        starts: number of equal starts.
    """

    def curve_of(each):
        return (speeds or {}).get(each["agent"], {0.0: each["speed"], 0.4: each["speed"]})

    return pd.DataFrame([
        {name: each[name] for name in KEY} | {"noise": noise, "start": start, "speed": speed}
        for each in runs
        for noise, speed in curve_of(each).items()
        for start in range(starts)
    ])  # fmt: skip


def curve(agent="a", regularization=0.0, seed=0, speed=(1.0,) * 10, window=10):
    """A learning curve."""
    return pd.DataFrame({
        "agent": agent, "regularization": regularization, "seed": seed,
        "decisions": [window * (i + 1) for i in range(len(speed))], "speed": speed,
    })  # fmt: skip


def tables(**by_agent):
    """Policy tables of a run with seed 3: agent={mode: table}."""
    return pd.concat(
        pd.DataFrame(table)
        .add_prefix("p_")
        .assign(agent=agent, mode=mode, regularization=0.0, seed=3, observation=range(len(table)))
        for agent, modes in by_agent.items()
        for mode, table in modes.items()
    )
