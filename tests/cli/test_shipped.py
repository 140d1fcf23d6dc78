"""Policies that come with the package: taken from results/, found by name from anywhere."""

import json

import pandas as pd
import pytest

from crawler_bench.config.files import shipped_policies
from crawler_bench.report import policies
from crawler_bench.runs.policies.files import read_policy
from tests.cli.command import ROOT, crawler_bench

RESULTS = ROOT / "results"


def test_what_ships_is_what_the_results_hold(tmp_path):
    """If this fails, the results are newer: run `python -m crawler_bench.report.policies`."""
    policies.write(RESULTS, tmp_path)
    made = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert made == {path.name: path.read_text() for path in policies.SHIPPED.iterdir()}


def test_the_two_gaits_and_the_best_of_each_learner_ship():
    found = {name: read_policy(path) for name, path in shipped_policies().items()}
    assert set(policies.GAITS) < set(found)
    runs = pd.read_csv(RESULTS / "benchmark" / "runs.csv")
    for agent in ("qlearning", "dqn", "ppo"):
        policy = found[agent]
        best = policies.collect(RESULTS)[agent][1]
        assert (policy.config.agent, policy.config.decisions > 0) == (agent, True)
        assert best in set(runs["speed"])
        assert best >= max(
            speed for each, speed in policies._compared(RESULTS / "benchmark") if each.config.agent == agent
        )


def test_a_policy_that_is_not_as_fast_as_the_results_say_is_refused():
    policy, speed = policies.collect(RESULTS)["regularized"]
    policies.require_speed("regularized", policy, speed)
    with pytest.raises(ValueError, match="they are older than the code"):
        policies.require_speed("regularized", policy, 1.1 * speed)


def test_a_shipped_policy_is_measured_by_its_name_from_anywhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    short = [word for each in ("starts=1", "duration=40", "settle=5", "gait=40") for word in ("--set", each)]
    words = ("evaluate", "regularized", *short, "--set", "evaluation.noise=[0, 0.1]", "--json")
    code, out, err = crawler_bench(*words)
    assert code == 0, err
    assert err.splitlines() == ["measuring 1 trained policy", "measuring 1/1 (regularized)"]
    found = json.loads(out)
    assert found["runs"][0]["run"] == "regularized"
    assert set(found["speeds"]["regularized"]) == {"0", "0.1"}
