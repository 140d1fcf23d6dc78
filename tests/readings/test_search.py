"""The search of the joint space: proposals, trials that are given up, the rule, going on after a stop."""

import json
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import optuna
import pandas as pd
import pytest

from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.readings.catalogue import LITERAL, Reading
from crawler_bench.readings.laboratory import EXPERIMENTS, REGULARIZED, UNREGULARIZED
from crawler_bench.readings.search import freeing as freeing_module
from crawler_bench.readings.search import holding as holding_module
from crawler_bench.readings.search import rounds, tables
from crawler_bench.readings.search.freeing import FACTORS, NOISE, SCALED, freeing
from crawler_bench.readings.search.holding import FINE, FURTHER, TIME_LIMIT, holding
from crawler_bench.readings.search.leads import LEADS
from crawler_bench.readings.search.off_diagonal import off_diagonal
from crawler_bench.readings.search.rounds import best, ordered_finals, run_again, run_trials
from crawler_bench.readings.search.space import CHOICES, CONSTANTS, draw, proposal
from crawler_bench.readings.search.trial import UNTRAINED, Trial, try_reading
from crawler_bench.readings.sizes import smoke
from tests.readings.test_scoring import plant, score


@pytest.fixture(scope="module")
def bases():
    paper = {name: load_experiment(config_folder() / "paper" / f"{name}.yaml").run for name in EXPERIMENTS}
    return {name: smoke().apply(run) for name, run in paper.items()}


@pytest.mark.parametrize("reading", LEADS, ids=lambda reading: reading.name)
def test_a_reading_is_drawn_as_it_was_proposed(reading):
    drawn = draw(optuna.trial.FixedTrial(proposal(reading)))
    assert drawn.keys() == {*CHOICES, *CONSTANTS}
    for key, value in drawn.items():
        close = isinstance(value, float)
        assert value == (pytest.approx(reading.changes[key], rel=5e-3) if close else reading.changes[key])


def test_a_body_without_the_papers_wave_is_given_up_before_anything_learns(bases):
    trial = try_reading(Reading("literal", "literal", LITERAL), bases, (0,))
    assert trial.stopped == "the wave's speed is far from the paper's"
    assert trial.runs.empty
    assert trial.wave_off > 0.5


def test_a_body_that_is_faster_at_random_is_given_up(bases):
    trial = try_reading(LEADS[0], bases, (0,))
    assert trial.stopped == "random action is faster than the wave"


def test_a_patient_trial_runs_everything(bases):
    trial = try_reading(Reading("literal", "literal", LITERAL), bases, (0, 1), patient=True)
    assert trial.stopped == ""
    assert trial.runs.groupby("experiment").size().to_dict() == dict.fromkeys(EXPERIMENTS, 2)


def rows(*found):
    columns = ["reading", "within", "free", "score", "distance", "stopped", "failures"]
    frame = pd.DataFrame(found, columns=columns)
    return frame.assign(changes=[json.dumps({"parameters.tau_f": i}) for i in range(len(frame))])


def test_the_nearest_of_each_number_of_constants_take_turns():
    trials = rows(
        ("far", False, 5, 2.0, 3.0, "", ""), ("near", False, 5, 1.1, 1.2, "", ""),
        ("seven", True, 7, 0.2, 0.3, "", ""), ("seven too", True, 7, 0.6, 0.4, "", ""),
        ("four", False, 4, 2.5, 3.9, "", ""), ("hopeless", True, 1, 0.0, 0.0, "too few", ""),
    )  # fmt: skip
    names = [each.name for each in best(trials, 9)]
    assert names == ["four", "near", "seven", "far", "seven too"]
    assert [each.name for each in best(trials, 2)] == names[:2]


def test_where_every_trial_is_hopeless_the_nearest_of_them_are_tried_again():
    trials = rows(
        ("far", False, 5, 2.0, 3.0, "too few", ""), ("near", False, 5, 1.1, 1.2, "random is fast", "")
    )
    assert [each.name for each in best(trials, 1)] == ["near"]


def test_a_trial_runs_the_other_gaits_with_fewer_seeds(bases):
    runs = try_reading(LEADS[1], bases, (0, 1), fewest=(), paired=1).runs
    assert runs.groupby("experiment").size().to_dict() == {REGULARIZED: 2, UNREGULARIZED: 1, UNTRAINED: 1}


def test_what_a_trial_never_runs_is_no_failure(bases):
    trial = try_reading(LEADS[1], bases, (0, 1, 2), fewest=(), paired=1)
    alone = try_reading(LEADS[1], bases, (0,), fewest=(), paired=1)
    of, of_one = (each.score.claims.set_index("claim") for each in (trial, alone))
    for claim in ("unused_muscles", "pairs", "loses_speed", "uncoordinated"):
        assert of.loc[claim, ["ours", "n"]].tolist() == of_one.loc[claim, ["ours", "n"]].tolist()
    assert of.loc["nearest_neighbour", "n"] == 3


def test_finalists_are_ordered_by_failures_constants_and_score():
    finals = rows(
        ("fails two", True, 1, 0.1, 0.1, "", "wave faster"), ("seven", True, 7, 0.2, 0.2, "", ""),
        ("six", True, 6, 0.4, 0.4, "", ""), ("six too", True, 6, 0.3, 0.3, "", ""),
    )  # fmt: skip
    assert ordered_finals(finals)["reading"].tolist() == ["six too", "six", "seven", "fails two"]


def test_a_finalist_fails_by_a_number_of_the_paper_and_by_fast_random_action():
    def failures(ratio, **regularized):
        results = plant(regularized=regularized)
        trial = Trial(LEADS[0], score(results, range(5)), results.runs)
        return rounds._failures(trial, ratio)

    assert failures(0.8) == []
    assert failures(0.91) == ["random_ratio"]
    assert failures(None) == ["random_ratio"]
    assert failures(0.8, waves_per_tau=0.031) == ["wave_speed"]
    assert failures(0.8, peak_contraction=0.28) == ["peak_contraction"]


@pytest.fixture
def seen():
    """What a bar would show: (name, done, total), and the phase that notes it."""
    shown = []

    @contextmanager
    def phase(name, total, unit):
        yield lambda done: shown.append((name, done, total))

    return shown, phase


def test_a_search_goes_on_where_it_stopped(bases, tmp_path, seen):
    shown, phase = seen

    def search(trials):
        said = []
        journal = tmp_path / "search" / "journal.log"
        found = run_trials(
            bases, journal, first=LEADS[:1], seeds=(0,), trials=trials, jobs=1, say=said.append, phase=phase
        )
        return found, said

    first, said = search(2)
    assert "2 trials" in said[-1]
    assert shown == [("trials", done, 2) for done in (0, 1, 2)]
    again, silent = search(2)
    pd.testing.assert_frame_equal(first, again)
    assert silent == []
    longer, _ = search(3)
    pd.testing.assert_frame_equal(first, longer.head(2))
    assert shown[3:] == [("trials", done, 3) for done in (2, 3)]
    assert json.loads(first["changes"][0]) == LEADS[0].changes
    assert (first["seconds"] > 0).all()


def test_most_trials_are_drawn_at_random(bases, tmp_path, monkeypatch):
    samplers = []

    def drawn(trial):
        samplers.append(type(trial.study.sampler))
        return draw(trial)

    monkeypatch.setattr(rounds, "draw", drawn)
    monkeypatch.setattr(rounds, "INFORMED", 2)
    run_trials(bases, tmp_path / "j.log", first=(), seeds=(0,), trials=3, jobs=1, say=str)
    informed, random = optuna.samplers.TPESampler, optuna.samplers.RandomSampler
    assert samplers[:3] == [informed, random, informed]


def test_later_rounds_look_up_what_is_finished(bases, tmp_path, seen):
    shown, phase = seen
    options = {"seeds": (0, 1), "folder": tmp_path, "jobs": 1, "say": str, "phase": phase}
    found = run_again(LEADS[:1], bases, **options)
    assert [each[1:] for each in shown] == [(1, 1)]
    assert found["n"].tolist() == [2]
    assert found["seconds"][0] > 0
    (kept,) = tmp_path.glob("*.json")
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {"score": -1.0}))
    assert run_again(LEADS[:1], bases, **options)["score"].tolist() == [-1.0]


def test_a_run_that_ends_off_the_diagonal_is_looked_into(bases, seen):
    shown, phase = seen
    entries = off_diagonal(LEADS[0], bases, (0,), phase)
    assert [each[1:] for each in shown] == [(1, 1)]
    assert set(entries["policy"]) == {entries["policy"][0]}
    digits = entries["policy"][0]
    assert [int(digits[o]) for o in entries["observation"]] == entries["action"].tolist()
    assert (entries["observation"] != entries["action"]).all()
    assert (entries["value"] >= entries["neighbour_value"]).all()


def test_each_field_is_changed_alone_to_see_which_frees_a_learner(bases, monkeypatch, seen):
    tried, (shown, phase) = [], seen

    def learns(config, seed, interval):
        tried.append((config, seed))
        on_diagonal = config.environment.noise == NOISE[-1]
        table = np.eye(10) if on_diagonal else np.eye(10)[::-1]
        return SimpleNamespace(q_table=table), None

    monkeypatch.setattr(freeing_module, "learn", learns)
    found = freeing(LEADS[0], bases, (3, 4), jobs=1, phase=phase)
    assert [done for _, done, _ in shown] == list(range(1, shown[0][-1] + 1))
    assert len(found) == 1 + 2 + len(SCALED) * len(FACTORS) + len(NOISE)
    assert found["n"].tolist() == [2] * len(found)
    assert found[found["on_diagonal"] == 1]["field"].tolist() == ["noise"]
    assert found[found["field"] == "time_limit"]["value"].tolist() == [1000 * each for each in FACTORS]
    assert {seed for _, seed in tried} == {3, 4}
    assert len({config.model_dump_json() for config, _ in tried}) == len(found)


def test_the_chosen_reading_is_tried_where_nothing_was_fitted(bases, monkeypatch, seen):
    tried, (shown, phase) = [], seen

    def tries(reading, bases, seeds, *, patient, measured_with):
        tried.append((reading.changes, tuple(seeds), measured_with))
        results = plant()
        return Trial(reading, score(results, range(5)), results.runs.assign(policy="0123456789"))

    monkeypatch.setattr(holding_module, "try_reading", tries)
    found = holding(LEADS[0], bases, (3, 4), jobs=1, phase=phase)
    assert [done for _, done, _ in shown] == list(range(1, len(found) + 1))
    assert found["case"].is_unique
    of = dict(zip(found["case"], tried, strict=True))
    changes, drawn, _ = of["further seeds, drawn at random"]
    assert changes == LEADS[0].changes
    assert len(set(drawn)) == FURTHER
    assert not set(drawn) & set(range(1000))
    assert of["trained and measured in steps of dt = 0.01"][0]["parameters.integrator"] == "step"
    assert of["trained policies in steps of dt = 0.002"][2] == FINE
    assert of["a time limit of 4,000 tau"][0]["environment.time_limit"] == TIME_LIMIT
    half = LEADS[0].changes["parameters.decision_interval"] / 2
    assert of["trained policies at half the decision interval"][2]["parameters.decision_interval"] == half
    changes, seeds, measured = of["trained and measured at half the decision interval"]
    assert (changes["parameters.decision_interval"], seeds, measured) == (half, (3, 4), {})


def test_a_trial_is_measured_with_what_is_changed_after_the_training(bases):
    def speed(**options):
        found = try_reading(LEADS[1], bases, (0,), patient=True, **options)
        return found.runs.set_index("experiment").loc[UNTRAINED, "speed"]

    assert speed(measured_with={"parameters.muscle_force_max": 0.5}) < 0.7 * speed()


def test_blocks_say_that_nothing_was_searched_yet(tmp_path):
    assert {block() for block in tables.blocks(tmp_path).values()} == {tables.NOT_SEARCHED}
