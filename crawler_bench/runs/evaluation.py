"""Measure a trained policy, frozen: from several starts, and under several amplitudes of noise.

A table goes through one compiled loop, whoever learned it; whatever is no table is asked at every decision,
from the same starts and with the same noise (`acting`).
"""

import itertools
import time
import zipfile
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from crawler_bench.config.schema import EvaluationConfig, RunConfig
from crawler_bench.gait import metrics
from crawler_bench.gait.record import Record
from crawler_bench.gait.rollout import rollout
from crawler_bench.gait.stepwise import Policy, crawl
from crawler_bench.runs import store
from crawler_bench.runs.folders import checksums, claims
from crawler_bench.runs.folders.keys import evaluation_key
from crawler_bench.runs.policies.acting import policy_of
from crawler_bench.runs.policies.table import probabilities
from crawler_bench.runs.training import load_agent
from crawler_bench.runs.untrusted import require_bounded

NO_TABLE = "none"  # the content of table.csv where the policy is no table


@dataclass(frozen=True)
class Evaluation:
    """What is known of one trained policy.

    Attributes:
        table: (N, N) probability of each action at each observation; (0, N) of a policy that is no table.
        starts: a row for each noise amplitude and start: noise, start, speed, reward, stalled and, without
            noise, the metrics of the gait.
        cycles: a row for each cycle: start, cycle, duration.
        nodes: a row for each start and node: power_peak, power_duration.
        gait: record of the first start that does not stall (of the first, where all do), settled.
    """

    table: NDArray[np.float64]
    starts: pd.DataFrame
    cycles: pd.DataFrame
    nodes: pd.DataFrame
    gait: Record


def evaluate(
    folder: Path,
    config: EvaluationConfig | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    trusted: Collection[str] = (),
    wait: bool = True,
    say: Callable[[str], None] = store.complain,
) -> Path:
    """Evaluate a trained run, unless it has been done, and is sound.

    Args:
        folder: the run.
        config: how; by default as the run's own configuration says.
        progress: is told how many crawls are done.
        trusted: names of agents that may be imported though a file names them, see `load_agent`.
        wait: for another process that evaluates the same run.
        say: told if the evaluation was there, but damaged.

    Returns:
        The folder of the evaluation, inside the run's.
    """
    run, seed = store.read_run(folder)
    chosen = config or run.evaluation
    place = evaluation_folder(folder, chosen)
    trained = checksums.identity(folder)

    def write(draft: Path) -> None:
        started = time.monotonic()
        agent, n_segments = load_agent(folder, run, trusted), run.parameters.n_segments
        policy = policy_of(agent, run.environment.keyhole, chosen.mode, n_segments, seed)
        evaluation = measure(run, seed, policy, chosen, progress)
        _write_table(evaluation.table, draft / "table.csv")
        for name in ("starts", "cycles", "nodes"):
            getattr(evaluation, name).to_csv(draft / f"{name}.csv", index=False)
        np.savez_compressed(draft / "gait.npz", **vars(evaluation.gait))
        store.write_manifest(draft, started, run=trained)

    if not place.exists():
        claims.sweep(folder)
    store.make(place, write, of=trained, wait=wait, say=say)
    return place


def evaluation_folder(folder: Path, config: EvaluationConfig) -> Path:
    """Where an evaluation of a run is kept, named by how it measures."""
    return folder / f"evaluation-{evaluation_key(config)}"


def read_evaluation(place: Path) -> Evaluation:
    """Read what `evaluate` wrote.

    Raises:
        NotARunError: if it is not as it was written.
    """
    if reason := checksums.damage(place):
        raise store.NotARunError(f"{reason}; repeat the command: it is measured again")
    try:
        starts, cycles, nodes = (pd.read_csv(place / f"{name}.csv") for name in ("starts", "cycles", "nodes"))
        starts[["noise", "start", "speed", "stalled"]], cycles["duration"]
        require_bounded(place / "gait.npz")
        with (place / "gait.npz").open("rb") as file, np.load(file) as arrays:
            gait = Record(**arrays)
        table = _read_table(place / "table.csv", gait.n_segments)
    except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile) as error:
        raise store.NotARunError(
            f"{place} is damaged ({type(error).__name__}); remove that folder and repeat the command"
        ) from None
    return Evaluation(table, starts, cycles, nodes, gait)


def _write_table(table: NDArray[np.float64], path: Path) -> None:
    if table.size:
        np.savetxt(path, table, delimiter=",", fmt="%.17g")
    else:
        path.write_text(NO_TABLE + "\n")


def _read_table(path: Path, n_segments: int) -> NDArray[np.float64]:
    lines = path.read_text().splitlines()
    if lines == [NO_TABLE]:
        return np.empty((0, n_segments))
    return probabilities([line.split(",") for line in lines], n_segments)


def measure(
    run: RunConfig,
    seed: int,
    policy: NDArray[np.float64] | Policy,
    config: EvaluationConfig,
    progress: Callable[[float], None] | None = None,
) -> Evaluation:
    """Roll a policy out from every start under every noise, and take its measure.

    Args:
        run: what it was trained in.
        seed: of the draws of a table.
        policy: a table, (N, N), or what is asked at every decision.
        config: how to measure.
        progress: is told how many crawls are done.
    """
    longest = max(config.duration, config.settle + config.gait)
    crawls = _crawls(run, seed, policy, config, longest)
    penalty = run.environment.regularization
    if run.parameters.penalty == "rate":
        penalty *= run.parameters.decision_interval
    rows, cycles, nodes, gaits = [], [], [], []
    for noise in config.noise:
        for start in range(config.starts):
            quiet = noise == config.noise[0]
            whole = next(crawls)
            record = whole.before(config.duration)
            stalled = metrics.stalls(record)
            row: dict[str, Any] = {
                "noise": noise, "start": start, "speed": metrics.speed(record),
                "reward": metrics.reward(record, penalty), "stalled": stalled,
            }  # fmt: skip
            if quiet:
                # Later in the same crawl: strains that the random start has left relax slowly.
                gait = whole.before(config.settle + config.gait).after(config.settle)
                wave = metrics.wave(gait)
                row |= describe(gait, wave)
                cycles += [(start, i, duration) for i, duration in enumerate(wave.durations)]
                peaks, durations = metrics.power_peaks(gait), metrics.power_durations(gait)
                nodes += [(start, j, peaks[j], durations[j]) for j in range(peaks.size)]
                gaits.append((stalled, start, gait))
            rows.append(row)
            if progress is not None:
                progress(len(rows))
    return Evaluation(
        policy if isinstance(policy, np.ndarray) else np.empty((0, run.parameters.n_segments)),
        pd.DataFrame(rows),
        pd.DataFrame(cycles, columns=["start", "cycle", "duration"]),
        pd.DataFrame(nodes, columns=["start", "node", "power_peak", "power_duration"]),
        min(gaits, key=lambda gait: gait[:2])[2],
    )


def _crawls(
    run: RunConfig,
    seed: int,
    policy: NDArray[np.float64] | Policy,
    config: EvaluationConfig,
    longest: float,
) -> Iterator[Record]:
    """Every crawl, by noise and then by start; without noise each is `longest`."""
    keys = [(config.seed, start) for start in range(config.starts)]
    quiet, *noisy = config.noise
    if isinstance(policy, np.ndarray):
        for noise, start in itertools.product(config.noise, keys):
            yield rollout(
                run.parameters, policy, warm_up=config.warm_up, noise=noise, start=start, policy_seed=seed,
                duration=longest if noise == quiet else config.duration,
            )  # fmt: skip
        return
    for levels, duration in (([quiet], longest), (noisy, config.duration)):
        if levels:
            yield from crawl(
                run.parameters, policy, run.environment.keyhole, warm_up=config.warm_up, duration=duration,
                noise=np.repeat(levels, len(keys)).tolist(), starts=keys * len(levels),
            )  # fmt: skip


def describe(gait: Record, wave: metrics.Wave) -> dict[str, Any]:
    """The metrics of one settled gait, one value each."""
    return {
        "wave_order": wave.order,
        "cycles": len(wave.durations),
        "cycle_duration": float(wave.durations.mean()) if len(wave.durations) else float("nan"),
        "peak_contraction": metrics.peak_contraction(gait),
        "strain_range": metrics.strain_range(gait),
        "strain_gradient": metrics.strain_gradient(gait),
        "contracted_segments": metrics.contracted_segments(gait),
        "unused_muscles": len(metrics.unused_muscles(gait)),
        "visited_observations": len(metrics.visited_observations(gait)),
        "pairs_together": metrics.pairs_together(gait),
        "power_peak_unevenness": metrics.unevenness(metrics.power_peaks(gait)),
        "power_duration_unevenness": metrics.unevenness(metrics.power_durations(gait)),
        "power_periodicity": metrics.power_periodicity(metrics.power_by_phase(gait, wave.boundaries)),
        "power_per_distance": metrics.power_per_distance(gait),
    }
