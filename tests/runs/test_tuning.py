"""The search for settings: repeatable, resumable, and committed as it came out."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from crawler_bench.config.files import config_folder, load_experiment, load_tuning
from crawler_bench.config.schema import ConfigError, Tuning
from crawler_bench.runs import training, tuning
from crawler_bench.runs.tuning import tune

RESULTS = Path(__file__).parents[2] / "results" / "tuning"
SEARCH = """
agent: agents.qlearning:QLearning
decisions: 2000
seeds: 1000-1000
grid: {environment.regularization: [0.0, 0.01]}
evaluation: {starts: 2, warm_up: 5, duration: 40, settle: 10, gait: 40, noise: [0]}
trials: 6
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
    best, trials = tune(search(root), root / "runs", jobs=1, quiet=True, say=said.append)
    return root, best, trials, said


def test_the_best_trial_is_chosen(tuned):
    _, best, trials, said = tuned
    assert len(trials) == len(said) == 6
    row = trials.loc[trials["reward"].idxmax()]
    assert best.settings == {
        "learning_rate": row["settings.learning_rate"], "initial_q": row["settings.initial_q"]
    }  # fmt: skip
    assert trials["reward"].nunique() > 1
    assert trials["reward"].to_numpy() == pytest.approx(
        trials[["reward at 0", "reward at 0.01"]].mean(axis=1).to_numpy()
    )


def test_the_start_comes_first_and_all_stay_in_range(tuned):
    _, _, trials, _ = tuned
    assert trials.loc[0, "settings.learning_rate"] == 0.05
    assert trials.loc[0, "settings.initial_q"] == 0.2
    assert trials["settings.learning_rate"].between(0.01, 0.5).all()
    assert set(trials["settings.initial_q"]) <= {0.05, 0.2}


def test_repeated_it_looks_up_and_gives_the_same(tuned, monkeypatch):
    root, best, trials, _ = tuned
    monkeypatch.setattr(training, "make_agent", None)
    again = tune(search(root), root / "runs", jobs=1, quiet=True, say=lambda text: None)
    assert again[0] == best
    pd.testing.assert_frame_equal(again[1], trials)


@pytest.mark.parametrize("agent", ["dqn", "ppo", "qlearning"])
def test_the_committed_search_is_proposed_again(agent, monkeypatch, tmp_path):
    """Trial by trial, from the rewards that it was told: the sampler is seeded and sees no other numbers."""
    committed = pd.read_csv(RESULTS / f"{agent}.csv")
    rewards = iter(committed["reward"])
    monkeypatch.setattr(tuning, "_try", lambda *_, **__: {"reward": next(rewards), "error": ""})
    space = load_tuning(config_folder() / "tuning" / f"{agent}.yaml")
    trials = tune(space, tmp_path, jobs=1, quiet=True, say=lambda text: None)[1]
    for key in space.space:
        np.testing.assert_allclose(trials[key].astype(float), committed[key].astype(float), rtol=1e-8)


def test_a_trial_that_fails_is_listed(tmp_path):
    text = SEARCH.replace("values: [0.05, 0.2]", "values: [0.2, .inf]").replace("trials: 6", "trials: 5")
    best, trials = tune(search(tmp_path, text), tmp_path / "runs", jobs=1, quiet=True, say=lambda text: None)
    failed = trials[trials["settings.initial_q"] == float("inf")]
    assert len(failed) > 0
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
    folder = config_folder()
    searched = load_tuning(folder / "tuning" / f"{agent}.yaml")
    entry = load_experiment(folder / "benchmark" / f"{agent}-tuned.yaml")
    trials = pd.read_csv(RESULTS / f"{agent}.csv")
    assert len(trials) == searched.trials
    best = trials.loc[trials["reward"].idxmax()]
    found = yaml.safe_load((RESULTS / f"{agent}.yaml").read_text())["settings"]
    for key in searched.space:
        name = key.removeprefix("settings.")
        assert entry.run.settings[name] == found[name] == pytest.approx(best[key], rel=1e-8)
    assert not set(searched.seeds) & set(entry.seeds)
    assert load_experiment(folder / "benchmark" / f"{agent}.yaml").run.decisions == entry.run.decisions
