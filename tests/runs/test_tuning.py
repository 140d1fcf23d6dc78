"""The search for settings: repeatable, resumable, and committed as it came out."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.entries import tuned_entry
from crawler_bench.config.files import config_folder, load_experiment, load_tuning
from crawler_bench.config.schema import ConfigError, Tuning
from crawler_bench.runs import training, tuning
from crawler_bench.runs.tuning import COMPLETE, FAILED, PRUNED, tune

RESULTS = Path(__file__).parents[2] / "results" / "tuning"
SEARCH = """
agent: agents.qlearning:QLearning
decisions: 2000
seeds: 1000-1001
evaluation: {starts: 2, warm_up: 5, duration: 40, settle: 10, gait: 40, noise: [0]}
trials: 12
space:
  settings.learning_rate: {start: 0.05, low: 0.01, high: 0.5, log: true}
  settings.initial_q: {start: 0.2, values: [0.05, 0.2]}
"""


def search(tmp_path: Path, text: str = SEARCH) -> Tuning:
    (tmp_path / "search.yaml").write_text(text)
    return load_tuning(tmp_path / "search.yaml")


@pytest.fixture(scope="module")
def tuned(tmp_path_factory):
    root = tmp_path_factory.mktemp("tuning")
    said: list[str] = []
    best, trials, importance = tune(search(root), root / "runs", jobs=1, quiet=True, say=said.append)
    return root, best, trials, said, importance


def test_the_best_trial_is_chosen(tuned):
    _, best, trials, said, _ = tuned
    assert len(trials) == len(said) == 12
    complete = trials[trials["state"] == COMPLETE]
    row = complete.loc[complete["reward"].idxmax()]
    assert best.settings == {
        "learning_rate": row["settings.learning_rate"], "initial_q": row["settings.initial_q"]
    }  # fmt: skip
    assert trials["reward"].nunique() > 1
    assert trials["reward"].to_numpy() == pytest.approx(
        trials[["reward_1000", "reward_1001"]].mean(axis=1).to_numpy()
    )


def test_hopeless_trials_are_pruned_and_kept(tuned):
    """After the first seed, if that was below the median of the first seeds of complete trials."""
    _, _, trials, _, _ = tuned
    assert set(trials["state"]) == {COMPLETE, PRUNED}
    for number, trial in trials.iterrows():
        before = trials[:number].query("state == 'complete'")["reward_1000"]
        is_pruned = number >= tuning.STARTUP_TRIALS and trial["reward_1000"] < before.median()
        assert trial["state"] == (PRUNED if is_pruned else COMPLETE)
        assert trial["seeds"] == (1 if is_pruned else 2)
        assert np.isnan(trial["reward_1001"]) == is_pruned


def test_every_setting_has_its_importance(tuned):
    importance = tuned[4]
    assert sorted(importance["setting"]) == ["settings.initial_q", "settings.learning_rate"]
    assert importance["importance"].sum() == pytest.approx(1)
    assert importance["importance"].is_monotonic_decreasing


def test_an_entry_is_made_of_what_was_found(tuned, tmp_path):
    root, best, *_ = tuned
    qlearning = search(root).model_copy(update={"name": "qlearning"})
    (tmp_path / "qlearning-tuned.yaml").write_text(tuned_entry(qlearning, best))
    entry = load_experiment(tmp_path / "qlearning-tuned.yaml")
    default = load_experiment(config_folder() / "benchmark" / "qlearning.yaml")
    assert entry.run.settings == best.settings
    assert (entry.run.decisions, entry.seeds, entry.grid) == (
        default.run.decisions,
        default.seeds,
        default.grid,
    )


def test_the_start_comes_first_and_all_stay_in_range(tuned):
    _, _, trials, _, _ = tuned
    assert trials.loc[0, "settings.learning_rate"] == 0.05
    assert trials.loc[0, "settings.initial_q"] == 0.2
    assert trials["settings.learning_rate"].between(0.01, 0.5).all()
    assert set(trials["settings.initial_q"]) <= {0.05, 0.2}


def test_repeated_it_looks_up_and_gives_the_same(tuned, monkeypatch):
    root, best, trials, _, importance = tuned
    monkeypatch.setattr(training, "make_agent", None)
    again = tune(search(root), root / "runs", jobs=1, quiet=True, say=lambda text: None)
    assert again[0] == best
    pd.testing.assert_frame_equal(again[1], trials)
    pd.testing.assert_frame_equal(again[2], importance)


def test_a_trial_that_fails_is_listed(tmp_path):
    text = SEARCH.replace("values: [0.05, 0.2]", "values: [0.2, .inf]").replace("trials: 12", "trials: 5")
    best, trials, _ = tune(
        search(tmp_path, text), tmp_path / "runs", jobs=1, quiet=True, say=lambda text: None
    )
    failed = trials[trials["settings.initial_q"] == float("inf")]
    assert len(failed) > 0
    assert set(failed["state"]) == {FAILED}
    assert failed["error"].str.contains("initial_q").all()
    assert best.settings["initial_q"] == 0.2
    hopeless = text.replace("start: 0.2,", "start: .inf,").replace("trials: 5", "trials: 1")
    with pytest.raises(RuntimeError, match="all 1 trials failed"):
        tune(search(tmp_path, hopeless), tmp_path / "runs", jobs=1, quiet=True, say=lambda text: None)


def test_a_search_needs_a_space(tmp_path):
    with pytest.raises(ConfigError, match="space"):
        search(tmp_path, SEARCH.partition("space:")[0])


@pytest.mark.parametrize("agent", ["dqn", "ppo", "qlearning"])
def test_what_is_compared_as_tuned_is_what_the_search_found(agent):
    """The committed trials and the entry tell the same; the search has the size that is claimed for it."""
    folder = config_folder()
    searched = load_tuning(folder / "tuning" / f"{agent}.yaml")
    entry = load_experiment(folder / "benchmark" / f"{agent}-tuned.yaml")
    assert searched.trials >= 60
    assert len(searched.seeds) >= 3
    assert not set(searched.seeds) & set(entry.seeds)
    assert load_experiment(folder / "benchmark" / f"{agent}.yaml").run.decisions == entry.run.decisions
    path = RESULTS / agent / "trials.csv"
    if not path.is_file():
        pytest.skip("results/tuning was written by an earlier search: run `crawler-bench tune` again")
    trials = pd.read_csv(path)
    assert len(trials) == searched.trials
    complete = trials[trials["state"] == COMPLETE]
    best = complete.loc[complete["reward"].idxmax()]
    for key in searched.space:
        assert entry.run.settings[key.removeprefix("settings.")] == pytest.approx(best[key], rel=1e-8)
