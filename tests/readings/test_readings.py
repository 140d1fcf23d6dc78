"""What a reading is, what it runs, and that a small study can be written, read and run again."""

import json
from dataclasses import replace

import pandas as pd
import pytest

from crawler_bench.config.files import config_folder, load_experiment
from crawler_bench.config.schema import RunConfig
from crawler_bench.paper.verdicts import Results
from crawler_bench.readings import identifiability, laboratory, tables
from crawler_bench.readings.catalogue import DEFAULT, LITERAL, Reading, find_reading, readings, values_of
from crawler_bench.readings.fields import FIELDS, GIVEN, NO_LIMIT, REGULARIZATION
from crawler_bench.readings.frames import read_reading, summarize
from crawler_bench.readings.laboratory import Laboratory, Scored
from crawler_bench.readings.scoring import CAP, RESAMPLES
from crawler_bench.readings.search.space import CONSTANTS
from crawler_bench.readings.sizes import FULL, smoke
from crawler_bench.readings.study import Study, is_rival
from crawler_bench.report import blocks
from crawler_bench.runs.sweep import Cell, Outcome
from tests.readings.test_scoring import plant, score

ALL = readings()


@pytest.fixture(scope="module")
def bases() -> dict[str, RunConfig]:
    names = ("regularized", "unregularized", "untrained")
    return {name: load_experiment(config_folder() / "paper" / f"{name}.yaml").run for name in names}


def test_every_reading_has_its_own_name_and_its_own_values(bases):
    assert len({each.name for each in ALL}) == len(ALL) >= 60
    values = [
        json.dumps(values_of(each.configure(bases["regularized"])) | {"name": ""}, sort_keys=True)
        for each in ALL
    ]
    assert len(set(values)) == len(values)


def test_every_field_is_tried_alone_and_starts_from_a_value_that_the_default_has_not(bases):
    default = values_of(bases["regularized"])
    for field in (*FIELDS, *GIVEN):
        alone = [each for each in ALL if each.family in ("alone", "given") and field.key in each.changes]
        assert {each.changes[field.key] for each in alone} == set(field.tried)
        assert field.name == "dt" or default[field.key] not in field.tried
        assert field.words


def test_the_search_varies_the_fields_that_are_called_continuous():
    assert set(CONSTANTS) == {field.key for field in FIELDS if field.continuous}


def test_a_reading_changes_what_it_says_and_nothing_else(bases):
    run = find_reading("tau_f=1", ALL).configure(bases["regularized"])
    before, after = values_of(bases["regularized"]), values_of(run)
    assert {key for key in before if before[key] != after[key]} == {"parameters.tau_f"}


def test_epsilon_belongs_to_the_regularized_gait_alone(bases):
    reading = find_reading("regularization=0.05", ALL)
    assert reading.configure(bases["regularized"]).environment.regularization == 0.05
    assert reading.configure(bases["unregularized"]) == bases["unregularized"]


def test_the_untrained_crawler_shares_its_run_where_readings_share_a_body(bases):
    untrained = {each.name: each.configure(bases["untrained"]) for each in ALL}
    assert untrained["initial_q=1"] == untrained["time_limit=500"] == untrained["default"]
    assert untrained["tau_f=1"] != untrained["default"]


def test_the_literal_reading_takes_every_equation_as_printed(bases):
    literal = find_reading("literal", ALL)
    run = literal.configure(bases["regularized"])
    assert run.parameters.friction_law == "literal"
    assert run.parameters.observation == "most_stretched"
    assert run.environment.time_limit == NO_LIMIT
    assert literal.free_constants(bases["regularized"]) == ("initial_q", "episode_distance")


def test_the_repairs_lead_from_the_literal_reading_to_the_default():
    steps = [dict(each.changes) for each in ALL if each.family in ("literal", "repairs")]
    assert [len(step) for step in steps] == list(range(len(LITERAL), 1, -1))
    assert steps[-1].keys() == {"parameters.decision_interval", "parameters.tau_f"}


def test_free_constants_are_those_without_a_source(bases):
    base = bases["regularized"]
    default = set(DEFAULT.free_constants(base))
    assert default == {"neuron_rate", "initial_q", "episode_distance"}
    assert set(find_reading("neuron_rate=1", ALL).free_constants(base)) == default - {"neuron_rate"}
    assert set(find_reading("tau_f=0.7", ALL).free_constants(base)) == default | {"tau_f"}
    assert set(find_reading("tau_m=2", ALL).free_constants(base)) == default | {"tau_m"}
    assert set(find_reading("head_muscle=none", ALL).free_constants(base)) == default
    assert set(find_reading("dt=0.038", ALL).free_constants(base)) == default | {"dt"}
    assert set(find_reading("dt=0.01", ALL).free_constants(base)) == default


def test_an_unknown_reading_gets_one_line_with_a_suggestion():
    with pytest.raises(
        ValueError, match=r"no reading is called 'head_muscle=react'; did you mean 'head_muscle=reaction'"
    ):
        find_reading("head_muscle=react", ALL)


def test_presets_know_their_readings():
    assert FULL.readings() == ALL
    assert {each.name for each in smoke().readings()} == set(smoke().names)
    assert len(FULL.seeds) >= 5
    assert not set(FULL.seeds) & set(FULL.fresh)


def scored(name: str, base: RunConfig, results: Results, **changes: object) -> Scored:
    reading = Reading(name, "alone", changes)
    values = values_of(reading.configure(base))
    runs = results.runs.assign(policy="0", run="r", stall_share=0.0, power_per_distance=1.0)
    return Scored(reading, values, reading.free_constants(base), score(results, range(5)), runs, ())


def test_the_default_gives_way_only_to_a_reading_that_is_firmly_better_on_fresh_seeds(bases):
    base = bases["regularized"]
    poor = plant(regularized={"peak_contraction": 0.40}, unregularized={"unused_muscles": 0})
    default = scored("default", base, poor)
    better = scored("tau_f=1", base, plant(), **{"parameters.tau_f": 1.0})
    costly = scored("tau_m=2", base, plant(), **{"parameters.tau_m": 2.0})
    wrong = scored("tau_f=0.4", base, plant(regularized={"wave_order": 0.0}), **{"parameters.tau_f": 0.4})
    assert is_rival(better, default)
    assert not is_rival(costly, default)  # one more free constant
    assert not is_rival(wrong, default)  # a core claim fails
    assert not is_rival(default, default)
    for confirmed, replaces in (([default, better], [False, True]), ([default, default], [False, False])):
        study = Study(FULL, [default, better], confirmed)
        assert study.confirmation()["replaces"].tolist() == replaces


def test_a_profile_says_which_groups_a_field_moves(bases):
    base = bases["regularized"]
    found = [
        scored("default", base, plant()),
        scored("tau_f=1", base, plant(regularized={"peak_contraction": 0.5}), **{"parameters.tau_f": 1.0}),
        scored("tau_f=0.7", base, plant(), **{"parameters.tau_f": 0.7}),
    ]
    row = identifiability.profiles(found, [field for field in FIELDS if field.name == "tau_f"]).iloc[0]
    assert row["tried"] == "0.4, 0.7, 1"
    assert row["moved"] == "peak"
    assert row["not_worse"] == "0.4, 0.7"
    alike, of, names = identifiability.indistinct(found)
    assert (alike, of, names) == (1, 3, ["tau_f=0.7"])


def test_conclusions_are_counted_over_readings(bases):
    base = bases["regularized"]
    slow = plant(unregularized={"speed": 0.005, "speed_moving": 0.005})
    found = [scored("default", base, plant()), scored("tau_f=1", base, slow, **{"parameters.tau_f": 1.0})]
    rows = identifiability.conclusions(found).set_index(["conclusion", "population"])
    assert rows.loc[("the unregularized gait is faster", "all readings"), "holds"] == 0.5
    assert rows.loc[("the unregularized gait is faster", "within tolerance"), "readings"] == 1
    assert rows.loc[("learning pays, regularized", "all readings"), "firmly"] == 1


def test_a_row_of_the_table_is_a_reading_again(bases):
    found = [scored("default", bases["regularized"], plant())]
    found.append(scored("search-07", bases["regularized"], plant(), **{"parameters.tau_f": 0.9}))
    rows = summarize(found).set_index("reading", drop=False)
    again = read_reading({str(key): value for key, value in rows.loc["search-07"].items()})
    assert again == found[1].reading
    assert rows.loc["search-07", "tau_f"] == 0.9
    assert rows["rank"].tolist() == [1, 2]


def test_the_ranking_marks_the_default_and_says_what_the_search_tried(bases):
    found = [scored("default", bases["regularized"], plant())]
    search = scored("search-07", bases["regularized"], plant(), **{"parameters.tau_f": 0.9})
    table = tables.ranking(
        summarize([*found, replace(search, reading=replace(search.reading, family="search"))])
    )
    assert table["reading"].tolist() == ["**default**", "search-07: tau_f 0.9"]
    assert table["within tolerance"].tolist() == ["yes", "yes"]


def test_what_two_readings_share_runs_once(bases, tmp_path):
    small = {
        name: smoke().apply(run).model_copy(update={"decisions": min(run.decisions, 500)})
        for name, run in bases.items()
    }
    laboratory = Laboratory(small, tmp_path, jobs=1, quiet=True)
    chosen = [find_reading(name, ALL) for name in ("default", "initial_q=1", "regularization=0.05")]
    first = laboratory.run(chosen, (0,))
    # default: 3 runs; initial_q: both gaits; regularization: the regularized gait alone
    assert len(list(tmp_path.iterdir())) == 6
    assert not any(each.errors for each in first)
    assert "speed_at_noise_0.2" in first[0].runs
    again = laboratory.run(chosen, (0,))
    for one, other in zip(first, again, strict=True):
        assert one.score.value == other.score.value
        pd.testing.assert_frame_equal(one.runs, other.runs)


def test_a_reading_that_cannot_run_is_kept_and_counts_as_silence(bases, tmp_path):
    broken = {name: smoke().apply(run) for name, run in bases.items()}
    wrong = Reading("wrong", "alone", {"settings.nonsense": 1})
    (found,) = Laboratory(broken, tmp_path, jobs=1, quiet=True).run([wrong], (0,))
    assert len(found.errors) == 2
    assert "knows no 'nonsense'" in found.errors[0]
    assert not found.score.within
    assert found.score.resamples.shape == (RESAMPLES,)


def test_the_documentation_has_a_generator_for_every_block(tmp_path):
    names = tables.blocks(tmp_path)
    assert {"readings summary", "readings ranking", "readings fields", "readings conclusions"} <= set(names)
    assert set(names) <= set(blocks.blocks(tmp_path))


def test_epsilon_is_given_and_not_open():
    assert REGULARIZATION in {field.key for field in GIVEN}
    assert not {field.key for field in FIELDS} & {field.key for field in GIVEN}


def test_a_reading_whose_runs_all_failed_is_scored_as_far_away(bases, tmp_path, monkeypatch):
    """As where the disk is full."""
    monkeypatch.setattr(laboratory, "run_experiments", lambda experiments, *_, **__: failed(experiments))

    def failed(experiments):
        found = []
        for each in experiments:
            for config, seed in each.runs():
                cell = Cell(each.name, config, seed)
                found.append(Outcome(cell, None, None, "the disk is full"))
        return found

    lab = Laboratory(bases, tmp_path, jobs=1, quiet=True)
    with pytest.raises(RuntimeError, match="all 6 runs failed; the first: the disk is full"):
        lab.run([DEFAULT], (0, 1))
    monkeypatch.setattr(laboratory, "require_success", lambda _: None)
    (scored,) = lab.run([DEFAULT], (0, 1))
    assert len(scored.errors) == 6
    assert scored.runs.empty
    assert 4 < scored.score.value <= CAP  # shares of runs that failed are 0, not unknown
    assert len(summarize([scored])) == 1
