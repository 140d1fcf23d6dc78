"""Who is compared with whom, how far that can decide, and how runs are spread."""

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.entries import traits
from crawler_bench.benchmark.families import QUESTIONS, family, traits_of
from crawler_bench.benchmark.keyholes import keyhole_worth, profiles
from crawler_bench.benchmark.pairwise import compare
from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.statistics.profiles import performance_profile
from crawler_bench.statistics.significance import permutation_p, seeds_to_decide
from tests.benchmark.frames import evaluated, runs_of

D, S = "deterministic", "stochastic"
ENTRIES = [load_experiment(path) for path in sorted((config_folder() / "benchmark").glob("*.yaml"))]
TRAITS = traits_of(traits(ENTRIES))


@pytest.mark.parametrize(
    ("first", "second", "question"),
    [
        (("dqn", D, 0.0), ("dqn", S, 0.0), "mode"),
        (("dqn", D, 0.0), ("dqn", D, 0.01), "regularization"),
        (("dqn", D, 0.0), ("dqn", S, 0.01), None),
        (("dqn", D, 0.0), ("dqn-tuned", D, 0.0), "tuning"),
        (("dqn", D, 0.0), ("ppo-tuned", D, 0.0), None),
        (("dqn", D, 0.0), ("ppo", D, 0.0), "algorithm"),
        (("dqn", D, 0.0), ("ppo", S, 0.0), None),
        (("qlearning", D, 0.0), ("ppo", S, 0.0), "algorithm"),  # the table has one mode only
        (("dqn-tuned", D, 0.0), ("qlearning-tuned", D, 0.0), "tuned algorithm"),
        (("ppo", S, 0.0), ("ppo-strain", S, 0.0), "keyhole"),
        (("ppo-strain", S, 0.0), ("ppo-state", S, 0.0), "keyhole"),
        (("dqn-strain", D, 0.0), ("ppo-state", D, 0.0), None),
        (("ppo", D, 0.0), ("recurrent-ppo", D, 0.0), "memory"),
        (("ppo-state", D, 0.0), ("recurrent-ppo", D, 0.0), "memory"),
        (("ppo-strain", D, 0.0), ("recurrent-ppo", D, 0.0), None),
        (("dqn", D, 0.0), ("wave", D, 0.0), "reference"),
        (("random", S, 0.0), ("wave", D, 0.0), None),
    ],
)
def test_a_pair_answers_one_question_or_none(first, second, question):
    modes = dict.fromkeys(TRAITS, 2) | {"qlearning": 1, "qlearning-tuned": 1, "wave": 1, "random": 1}
    assert family(first, second, TRAITS, modes) == question
    assert family(second, first, TRAITS, modes) == question
    assert question is None or question in QUESTIONS


def test_holm_corrects_within_a_question_and_says_how_many_tests():
    rng = np.random.default_rng(0)
    rows = [
        row
        for name in ("dqn", "ppo", "dqn-tuned", "wave")
        for row in runs_of(name, "reward", rng.normal(size=12))
    ]
    pairs = compare(pd.DataFrame(rows), evaluated(rows), traits(ENTRIES))
    rewards = pairs[pairs["metric"] == "reward"]
    assert rewards["family"].value_counts().to_dict() == {"reference": 3, "algorithm": 1, "tuning": 1}
    assert dict(zip(rewards["family"], rewards["tests"], strict=True)) == {
        "reference": 3,
        "algorithm": 1,
        "tuning": 1,
    }
    alone = rewards[rewards["tests"] == 1]
    assert (alone["p_holm"] == alone["p"]).all()


def test_as_many_seeds_as_it_says_are_enough_and_half_are_not():
    """By simulation: with these seeds a difference as large passes Holm's hardest step in 80 % of cases."""
    rng, tests = np.random.default_rng(0), 10
    pilot = rng.normal(1.0, 1.0, size=4000), np.zeros(4000)
    needed = int(seeds_to_decide(*pilot, tests))

    def power(seeds: int) -> float:
        drawn = rng.normal(1.0, 1.0, size=(200, seeds))
        t = drawn.mean(axis=1) / drawn.std(axis=1, ddof=1) * np.sqrt(seeds)
        from scipy.stats import t as student

        return float((2 * student.sf(np.abs(t), seeds - 1) < 0.05 / tests).mean())

    assert power(needed) > 0.7
    assert power(needed // 2) < 0.5


def test_no_fewer_seeds_than_permutations_need():
    sure = np.full(12, 2.0) + 1e-9 * np.arange(12), np.zeros(12)
    for tests in (1, 10, 100):
        seeds = int(seeds_to_decide(*sure, tests))
        least = permutation_p(sure[0][:seeds], sure[1][:seeds]) if seeds <= 12 else 2.0 ** (1 - seeds)
        assert least <= 0.05 / tests
        assert 2.0 ** (1 - (seeds - 1)) > 0.05 / tests
    assert np.isnan(seeds_to_decide(np.ones(3), np.ones(3)))


def test_a_profile_is_the_share_of_runs_above():
    share, low, high = performance_profile([1.0, 2.0, 3.0, np.nan], [0.0, 1.5, 3.0])
    assert share.tolist() == [1, pytest.approx(2 / 3), 0]
    assert (low <= share).all()
    assert (share <= high).all()
    assert high[1] > share[1] > low[1]
    frame = profiles(pd.DataFrame(runs_of("a", "reward", [0.0, 1.0, 2.0])).assign(score=np.nan))
    assert set(frame["of"]) == {"reward"}
    assert frame["share"].iloc[0] == pytest.approx(2 / 3)
    assert frame["share"].iloc[-1] == 0


def test_worth_of_a_keyhole_leaves_out_who_has_but_one():
    names = ("ppo", "ppo-strain", "recurrent-ppo", "ppo-tuned", "a2c", "wave")
    rows = [(name, D, 0.0, "reward", 1.0, 1.0, 1.0, 2, "x") for name in names]
    columns = ["agent", "mode", "regularization", "metric", "value", "low", "high", "n", "hash"]
    found = keyhole_worth(pd.DataFrame(rows, columns=columns), traits(ENTRIES))
    assert found[["agent", "algorithm", "keyhole", "memory"]].to_numpy().tolist() == [
        ["ppo", "ppo", "index", False], ["recurrent-ppo", "ppo", "index", True],
        ["ppo-strain", "ppo", "strain", False],
    ]  # fmt: skip
