"""The benchmark from entries to results: both modes, failures, re-run cells, policies as files."""

import json

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.benchmark import require_comparable, run_benchmark
from crawler_bench.benchmark.cell_hash import Hasher
from crawler_bench.benchmark.keys import RUN, select
from crawler_bench.benchmark.reproduce_cell import reproduce
from crawler_bench.benchmark.results import write_benchmark
from crawler_bench.benchmark.summary import METRICS, summarize_benchmark
from crawler_bench.config.schema import ConfigError, Experiment, RunConfig, override
from crawler_bench.output.csv_files import read_csv, rounded
from crawler_bench.runs import evaluation, store
from crawler_bench.runs.policies import files as policy_files

SHORT = {
    "starts": 2, "warm_up": 5, "duration": 40, "settle": 20, "gait": 60, "evaluation.noise": [0, 0.1, 0.4],
}  # fmt: skip
GRID = {"environment.regularization": (0.0, 0.01)}
SMALL_PPO = {"settings.n_steps": 32, "settings.batch_size": 64, "settings.n_epochs": 1}


def entry(name: str, agent: str, **changes: object) -> Experiment:
    run = override(RunConfig(), {"agent": agent} | SHORT | changes, "test")
    return Experiment(name=name, run=run, seeds=(0, 1), grid=GRID)


ENTRIES = [
    entry("random", "agents.reference:Random", decisions=0),
    entry("wave", "agents.reference:Wave", decisions=0),
    entry("table", "agents.qlearning:QLearning", decisions=6000),
    entry("deep", "agents.deep:PPO", decisions=128, crawlers=2, **SMALL_PPO),
]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small benchmark, run and written."""
    root = tmp_path_factory.mktemp("benchmark")
    found = run_benchmark(ENTRIES, root / "runs", jobs=1, quiet=True)
    write_benchmark(found, ENTRIES, root / "out", say=lambda text: None)
    return root, found


def test_every_run_is_measured_in_the_modes_that_differ(made):
    _, found = made
    modes = found.runs.groupby("agent")["mode"].unique().map(sorted).to_dict()
    assert modes == {
        "random": ["stochastic"], "wave": ["deterministic"], "table": ["deterministic"],
        "deep": ["deterministic", "stochastic"],
    }  # fmt: skip
    counts = found.runs.groupby(["agent", "mode"]).size()
    assert set(counts) == {4}
    assert len(found.evaluations) == 5 * 4 * 3 * 2
    assert len(found.tables) == 5 * 4 * 10
    assert found.failures == []


def test_all_agents_meet_the_same_starts():
    """The warm-up before each start does not depend on the agent: the first sample is the same."""
    gaits = []
    for each, table in zip(ENTRIES[1:3], (np.eye(10), np.roll(np.eye(10), 1, axis=1)), strict=True):
        run = override(each.run, {"settle": 0}, "test")
        gaits.append(evaluation.measure(run, 0, table, run.evaluation).gait.displacement)
    np.testing.assert_array_equal(gaits[0][0], gaits[1][0])
    assert (gaits[0][-1] != gaits[1][-1]).any()


def test_gradient_updates_are_counted(made):
    _, found = made
    updates = found.runs.groupby("agent")["gradient_updates"].unique().map(list).to_dict()
    # 2 rollouts of 64 decisions, one epoch of one batch each.
    assert updates == {"random": [0], "wave": [0], "table": [0], "deep": [2]}
    assert set(found.curves["agent"]) == {"table"}  # too few points are kept of 128 decisions
    assert set(found.curves.groupby("seed").size()) == {2 * 6}  # one a thousand decisions
    last = found.curves.groupby(["agent", "regularization", "seed"]).last()
    assert list(last["decisions"]["table"]) == [6000] * 4


def test_results_hold_every_cell_with_its_hash(made):
    root, found = made
    names = {path.name for path in (root / "out").iterdir()}
    assert {
        "runs.csv", "evaluations.csv", "cycles.csv", "policy_tables.csv", "curves.csv", "summary.csv",
        "pairs.csv", "speeds.png", "noise.svg", "policies.png", "gaits.png",
        "softening.csv", "manifest.json", "command.txt", "policies", "entries", "tables",
    } <= names  # fmt: skip
    assert {"comparison.md", "comparison.tex", "comparison.csv"} <= {
        path.name for path in (root / "out" / "tables").iterdir()
    }
    summary = read_csv(root / "out" / "summary.csv")
    assert set(summary["metric"]) >= {metric.name for metric in METRICS}
    assert summary["hash"].str.fullmatch("[0-9a-f]{8}").all()
    assert summary["hash"].is_unique
    assert len(summary.groupby(["agent", "mode", "regularization"])) == 10
    runs = read_csv(root / "out" / "runs.csv")
    assert runs["hash"].is_unique
    assert len(runs) == len(found.runs)
    cost = json.loads((root / "out" / "manifest.json").read_text())["cost"]
    assert {agent: each["runs"] for agent, each in cost.items()} == dict.fromkeys(cost, 4)


def test_a_hash_stands_for_what_decides_a_cell():
    hasher = Hasher({each.name: each for each in ENTRIES})
    cells = [
        hasher(agent, mode, regularization, metric)
        for agent in ("table", "deep") for mode in ("deterministic", "stochastic")
        for regularization in (0.0, 0.01) for metric in ("speed", "reward")
    ]  # fmt: skip
    cells += [hasher.of_run("table", "deterministic", 0.0, seed) for seed in (0, 1)]
    other = ENTRIES[2].model_copy(update={"seeds": (0, 2)})
    longer = ENTRIES[2].model_copy(update={"run": override(ENTRIES[2].run, {"decisions": 6001}, "test")})
    assert hasher("table", "deterministic", 0.0, "speed") in cells
    twin = ENTRIES[2].model_copy(update={"name": "twin"})
    cells.append(Hasher({"twin": twin})("twin", "deterministic", 0.0, "speed"))
    for changed in (other, longer):
        cells.append(Hasher({"table": changed})("table", "deterministic", 0.0, "speed"))
    assert len(set(cells)) == len(cells)


@pytest.mark.parametrize(
    ("agent", "metric"), [("table", "speed"), ("deep", "regret"), ("random", "noise_area")]
)
def test_a_cell_that_is_run_again_is_equal(made, agent, metric):
    root, _ = made
    cell = select(read_csv(root / "out" / "summary.csv"), agent=agent, metric=metric).iloc[-1]
    again = reproduce(root / "out", cell["hash"], jobs=1, quiet=True)
    assert list(again["verdict"]) == ["equal"]
    assert again["now"].iloc[0] == cell["value"]


def test_the_tables_follow_from_the_csvs(made):
    """Where all runs agree an interval is no wider than the last digit: nothing may be rounded on the way."""
    root, _ = made
    runs, evaluations, curves, summary = (
        read_csv(root / "out" / f"{name}.csv") for name in ("runs", "evaluations", "curves", "summary")
    )
    hasher = Hasher({each.name: each for each in ENTRIES})
    again = rounded(summarize_benchmark(runs, evaluations, curves, hasher))
    pd.testing.assert_frame_equal(again, summary, check_exact=True)


def test_a_run_that_is_run_again_is_equal(made):
    root, _ = made
    run = select(read_csv(root / "out" / "runs.csv"), agent="deep").iloc[-1]
    again = reproduce(root / "out", run["hash"], jobs=1, quiet=True)
    assert set(again["verdict"]) == {"equal"}
    assert {"speed", "reward", "off_diagonal", "gradient_updates", "policy"} <= set(again["metric"])


def test_a_cell_that_was_changed_is_found_out(made, tmp_path):
    root, _ = made
    for path in (root / "out").glob("*.csv"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "entries").symlink_to(root / "out" / "entries")
    summary = read_csv(tmp_path / "summary.csv")
    row = summary[(summary["agent"] == "table") & (summary["metric"] == "reward")].index[0]
    true = summary.loc[row, "value"]
    for low, high, verdict in (
        (true - 1, true + 1, "within its interval"),
        (true + 1, true + 2, "different"),
    ):
        summary.loc[row, ["value", "low", "high"]] = true + 0.5, low, high
        summary.to_csv(tmp_path / "summary.csv", index=False)
        again = reproduce(tmp_path, summary.loc[row, "hash"], jobs=1, quiet=True)
        assert list(again["verdict"]) == [verdict]
    with pytest.raises(ConfigError, match="no cell or run has the hash ffffffff"):
        reproduce(tmp_path, "ffffffff", jobs=1, quiet=True)


def test_finished_runs_are_not_run_again_and_give_the_same(made, tmp_path, monkeypatch):
    root, _ = made
    monkeypatch.setattr("crawler_bench.runs.training.make_agent", None)
    found = run_benchmark(ENTRIES, root / "runs", jobs=1, quiet=True)
    write_benchmark(found, ENTRIES, tmp_path / "out", say=lambda text: None)
    for path in (root / "out").glob("*.csv"):
        assert path.read_bytes() == (tmp_path / "out" / path.name).read_bytes(), path.name


def test_a_failing_agent_is_listed_and_stops_nothing(tmp_path):
    broken = entry("broken", "agents.reference:Wave", decisions=0, **{"settings.temperature": 1})
    found = run_benchmark([ENTRIES[1], broken], tmp_path / "runs", jobs=1, quiet=True)
    assert set(found.runs["agent"]) == {"wave"}
    assert len(found.failures) == 4
    write_benchmark(found, [ENTRIES[1], broken], tmp_path / "out", say=lambda text: None)
    failures = pd.read_csv(tmp_path / "out" / "failures.csv")
    assert set(failures["agent"]) == {"broken"}
    assert failures["error"].str.contains("temperature").all()
    with pytest.raises(RuntimeError, match="all 4 runs failed"):
        run_benchmark([broken], tmp_path / "runs", jobs=1, quiet=True)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"decisions": 5}, "learns from 5 decisions and others from 6000"),
        ({"n_segments": 8}, "different parameters"),
        ({"evaluation.noise": [0]}, "different evaluation"),
    ],
)
def test_only_what_is_measured_alike_is_compared(changes, said):
    other = entry("other", "agents.qlearning:QLearning", **{"decisions": 6000} | changes)
    require_comparable(ENTRIES[:3])
    with pytest.raises(ConfigError, match=said):
        require_comparable([*ENTRIES[:3], other])
    with pytest.raises(ConfigError, match="table would be compared twice"):
        require_comparable([*ENTRIES[:3], ENTRIES[2]])
    varied = ENTRIES[2].model_copy(update={"name": "varied", "grid": {"settings.learning_rate": (0.1, 0.2)}})
    with pytest.raises(ConfigError, match="may hold environment"):
        require_comparable([*ENTRIES[:3], varied])


def test_policies_travel_as_files(made, tmp_path):
    root, found = made
    paths = sorted((root / "out" / "policies").glob("*.json"))
    assert len(paths) == 8
    assert {path.stem for path in paths if path.with_suffix(".zip").exists()} == {
        path.stem for path in paths if path.stem.startswith("deep")
    }
    for path in paths:
        policy = policy_files.read_policy(path)
        agent, _, _ = path.stem.partition("-eps")
        level = policy.config.environment.regularization
        row = select(found.runs, agent=agent, seed=policy.seed, regularization=level).iloc[0]
        measured = evaluation.measure(
            policy.config, policy.seed, policy.table_of(row["mode"]), policy.config.evaluation
        )
        quiet = measured.starts[measured.starts["noise"] == 0]
        assert quiet["speed"].mean() == row["speed"]
    (tmp_path / "no.json").write_text("{}")
    with pytest.raises(store.NotARunError, match="is not a policy"):
        policy_files.read_policy(tmp_path / "no.json")
    with pytest.raises(store.NotARunError, match="does not exist"):
        policy_files.read_policy(tmp_path / "nowhere.zip")


def test_an_unmodified_contributed_agent_trains_by_name(tmp_path):
    settings = {"settings.learning_starts": 32, "settings.buffer_size": 200}
    quantiles = entry("qrdqn", "sb3_contrib:QRDQN", decisions=64, crawlers=2, **settings)
    quantiles = quantiles.model_copy(update={"seeds": (0,), "grid": {}})
    found = run_benchmark([quantiles], tmp_path, jobs=1, quiet=True)
    assert not found.failures
    assert sorted(found.runs["mode"]) == ["deterministic", "stochastic"]
    assert found.runs[RUN].drop_duplicates().shape[0] == 2
