"""The best known tables: searched, certified, and above everything that is not them."""

import itertools
from contextlib import contextmanager

import numpy as np
import pandas as pd
import pytest

from crawler_bench.benchmark.ceilings import ceilings
from crawler_bench.benchmark.ceilings.ceilings import SMOKE, certificates, find_ceilings
from crawler_bench.benchmark.ceilings.objective import Objective
from crawler_bench.benchmark.ceilings.stochastic import evolve
from crawler_bench.benchmark.ceilings.tables import certify, climb
from crawler_bench.benchmark.summary import measure_runs
from crawler_bench.config.schema import RunConfig, override
from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.runs.evaluation import measure
from tests.benchmark.frames import evaluated, runs_of

TIMES = {"starts": 2, "warm_up": 20, "duration": 40, "settle": 0, "gait": 40, "evaluation.noise": [0, 0.1]}
FEW = CrawlerParameters(n_segments=3)  # 27 deterministic tables: all can be tried
RUN = override(RunConfig(parameters=FEW), TIMES, "test")


def objective(run=RUN, regularization=0.01, noise=0.0):
    return Objective(run.parameters, run.evaluation, regularization, noise)


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("table", [np.eye(3)[[1, 2, 0]], np.full((3, 3), 1 / 3)], ids=["sure", "drawn"])
def test_a_policy_is_worth_what_the_benchmark_says(table, noise):
    run = override(RUN, {"regularization": 0.01}, "test")
    starts = measure(run, 7, table, run.evaluation).starts
    expected = starts[starts["noise"] == noise]["reward"].mean()
    assert objective(noise=noise).of_table(table, policy_seed=7)[0] == pytest.approx(expected, rel=1e-9)


@pytest.fixture(scope="module")
def everything():
    """Worth of all 27 tables."""
    whole = objective()
    return {
        actions: whole.of_policy(np.array(actions))[0] for actions in itertools.product(range(3), repeat=3)
    }


def test_climbs_find_the_best_of_all(everything):
    found = climb(objective(), climbs=10, seed=0)
    assert found.worth == max(everything.values())
    assert 1 <= found.ended_there <= 10
    assert objective().of_policy(found.policy)[0] == found.worth


def test_a_certificate_holds_for_the_best_and_for_no_other(everything):
    best = max(everything.values())
    for actions, worth in everything.items():
        made = certify(objective(), np.array(actions))
        assert made.worth == worth
        assert made.changes == 3 * 2 + 3 * 4
        assert made.measured <= made.changes
        within_two = [
            other
            for choice, other in everything.items()
            if 0 < sum(a != b for a, b in zip(choice, actions, strict=True)) <= 2
        ]
        # Changes at observations that are never visited change nothing and are not measured.
        assert made.holds == (max(within_two) <= worth + 1e-12)
        assert made.holds or worth < best


def test_the_tree_finds_the_best_from_a_start(everything):
    alone = objective().quick(1, 1.0)
    worths = {actions: alone.of_policy(np.array(actions))[0] for actions in everything}
    best, policy, (ended, given_up, cut) = alone.best_of_tree(0, 3, limit=np.inf)
    assert best == pytest.approx(max(worths.values()), rel=1e-12)
    completed = np.where(policy < 0, 0, policy)
    assert worths[tuple(completed.tolist())] == pytest.approx(best)
    assert given_up == cut == 0
    assert ended <= 27
    fewer = alone.best_of_tree(0, 1, limit=np.inf)
    assert fewer[2][1] > 0  # tables that visit more are given up, and counted
    cut_off = alone.best_of_tree(0, 3, limit=2 * max(max(worths.values()), 0.0))
    assert cut_off[0] == best


def test_evolution_ends_above_the_table_it_began_from():
    found = evolve(objective(), climb(objective(), 5, 0).policy, generations=3, seed=0)
    np.testing.assert_allclose(found.table.sum(axis=1), 1)
    start = objective().of_policy(climb(objective(), 5, 0).policy)[0]
    assert found.worth >= start - 1e-12
    assert found.candidates > 3


def test_looking_ahead_is_no_worse_than_the_table_it_follows():
    best = climb(objective(), 5, 0)
    assert objective().of_lookahead(best.policy, 30) > best.worth


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    root = tmp_path_factory.mktemp("ceilings")
    said: list[str] = []
    found = find_ceilings(RUN, [0.0, 0.01], root, SMOKE, jobs=1, say=said.append)
    return root, found, said


def test_it_is_shown_how_many_tables_are_certified(found):
    seen: list[object] = []

    @contextmanager
    def phase(*words):
        seen.append(words)
        yield seen.append

    certificates(found[1], RUN, jobs=1, phase=phase)
    assert seen == [("certifying", 4, "tables"), 1, 2, 3, 4]


def test_all_ceilings_are_in_order_and_kept(found, monkeypatch):
    root, frame, said = found
    assert len(said) == 1
    counts = frame.groupby(["regularization", "noise"])["kind"].agg(list)
    assert counts[0.0, 0.0] == ["random", "table", "stochastic table", "state", "tree"]
    assert counts[0.01, 0.1] == ["random", "table", "stochastic table"]
    for _, rows in frame.groupby(["regularization", "noise"]):
        worth = rows.set_index("kind")["reward"]
        assert worth["random"] < worth["table"] <= worth["stochastic table"] + 1e-12
    assert frame["proof"].str.len().gt(10).all()
    monkeypatch.setattr(ceilings, "_search", None)  # looked up
    again = find_ceilings(RUN, [0.0, 0.01], root, SMOKE, jobs=1, say=said.append)
    pd.testing.assert_frame_equal(again, frame)
    assert len(said) == 1


def test_certificates_are_made_again_and_found_out(found):
    _, frame, _ = found
    made = certificates(frame, RUN, jobs=1)
    assert len(made) == 4
    assert made["holds"].all()
    worse = frame.assign(policy=frame["policy"].where(frame["kind"] != "table", "000"))
    assert not certificates(worse, RUN, jobs=1)["holds"].all()


def test_regrets_and_score_are_measured_against_them():
    rows = pd.DataFrame(runs_of("a", "reward", [1.0, 3.0, 5.0]))
    known = pd.DataFrame({
        "regularization": 0.0, "noise": [0.0, 0.0, 0.0, 0.0, 0.1], "reward": [1.0, 5.0, 6.0, 8.0, 99.0],
        "kind": ["random", "table", "stochastic table", "state", "table"],
    })  # fmt: skip
    measured = measure_runs(rows, evaluated(rows.to_dict("records")), None, known)
    assert measured["score"].tolist() == [0.0, 0.5, 1.0]
    assert measured["regret_table"].tolist() == [4.0, 2.0, 0.0]
    assert measured["regret_stochastic"].tolist() == [5.0, 3.0, 1.0]
    assert measured["regret_state"].tolist() == [7.0, 5.0, 3.0]
    assert measure_runs(rows, evaluated(rows.to_dict("records")))["score"].isna().all()
