"""Configurations: YAML over typed defaults, overrides, grids, seeds, and one-line errors."""

from pathlib import Path

import pytest
import yaml

from crawler_bench.config.files import (
    agent_spec,
    config_folder,
    load_experiment,
    load_tuning,
    parse_assignments,
    smoke_changes,
)
from crawler_bench.config.schema import (
    ConfigError,
    EvaluationConfig,
    Experiment,
    RunConfig,
    override,
    parse_seeds,
    resize,
    to_yaml,
)
from crawler_bench.physics.parameters import CrawlerParameters


@pytest.fixture
def load(tmp_path):
    def loader(text: str) -> Experiment:
        path = tmp_path / "mine.yaml"
        path.write_text(text)
        return load_experiment(path)

    return loader


def complaint(call, *arguments) -> str:
    """The one line of a ConfigError."""
    with pytest.raises(ConfigError) as caught:
        call(*arguments)
    message = str(caught.value)
    assert message
    assert "\n" not in message
    return message


def test_an_empty_file_is_all_defaults(load):
    experiment = load("")
    assert experiment.name == "mine"
    assert experiment.run == RunConfig()
    assert experiment.run.parameters == CrawlerParameters()
    assert experiment.seeds == tuple(range(10))


def test_values_lie_over_the_defaults(load):
    run = load("decisions: 7\nparameters: {n_segments: 4, tau_f: 0.4}\nevaluation: {starts: 3}").run
    assert run.decisions == 7
    assert run.parameters == CrawlerParameters(n_segments=4, tau_f=0.4)
    assert run.evaluation == EvaluationConfig(starts=3)
    assert run.environment == RunConfig().environment


@pytest.mark.parametrize("text", ["1e-4", "1E-4", "+1e-4", "1.e-4", ".1e-3", "0.0001"])
def test_every_spelling_of_a_number_is_one(load, text):
    experiment = load(f"environment: {{regularization: {text}}}\nsettings: {{learning_rate: {text}}}")
    assert experiment.run.environment.regularization == 1e-4
    assert experiment.run.settings == {"learning_rate": 1e-4}
    assert parse_assignments([f"regularization={text}"]) == {"regularization": 1e-4}


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("decision: 5", "decisions"),
        ("environment: {regularisation: 0}", "regularization"),
        ("parameters: {friction_foward: 1}", "friction_forward"),
        ("evaluation: {warmup: 1}", "warm_up"),
    ],
)
def test_an_unknown_key_names_the_nearest(load, text, meant):
    message = complaint(load, text)
    assert "mine.yaml: unknown key" in message
    assert f"did you mean {meant!r}?" in message


def test_an_unknown_key_unlike_any_lists_all(load):
    message = complaint(load, "environment: {zzz: 1}")
    assert "'environment.zzz'" in message
    assert "regularization, noise, episode_distance, time_limit" in message


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("environment: {regularization: abc}", "environment.regularization"),
        ("environment: {regularization: .nan}", "environment.regularization"),
        ("environment: {regularization: -0.1}", "environment.regularization"),
        ("environment: {episode_distance: .nan}", "environment.episode_distance"),
        ("environment: {time_limit: 0}", "environment.time_limit"),
        ("environment: 3", "environment"),
        ("decisions: 1.5", "decisions"),
        ("decisions: -1", "decisions"),
        ("agent: 4", "agent"),
        ("settings: 4", "settings"),
        ("parameters: {n_segments: 1}", "n_segments"),
        ("parameters: {damping: -1}", "damping"),
        ("parameters: {damping: .nan}", "damping"),
        ("parameters: {damping: [1]}", "damping"),
        ("parameters: {head_muscle: soft}", "head_muscle"),
        ("evaluation: {starts: 0}", "evaluation.starts"),
        ("evaluation: {gait: 0}", "gait"),
        ("evaluation: {noise: []}", "evaluation.noise"),
        ("evaluation: {noise: [0.1, 0.2]}", "evaluation.noise"),
        ("evaluation: {noise: [0, 0.2, 0.1]}", "evaluation.noise"),
        ("evaluation: {noise: [0, .nan]}", "evaluation.noise"),
        ("evaluation: {noise: [0, .inf]}", "evaluation.noise"),
        ("seeds: 0", "seeds"),
        ("seeds: [3, 3]", "seeds"),
        ("run: {decisions: 5}", "run"),
        ("grid: {decisions: 5}", "grid.decisions"),
    ],
)
def test_a_bad_value_names_file_and_key(load, text, key):
    message = complaint(load, text)
    assert "mine.yaml: " in message
    assert key in message


@pytest.mark.parametrize(
    "text",
    [
        "- 1",
        "3",
        "decisions: [",
        "\t: x",
        "[" * 5000,
        "decisions: 1\nagent: ppo\ndecisions: 2",
        "settings: {a: 1, a: 2}",
        "settings: {a: &a [1], b: *a}",
    ],
    ids=lambda text: text[:20],
)
def test_a_file_that_is_no_mapping(load, text):
    assert "mine.yaml" in complaint(load, text)


def test_a_misspelt_agent_names_those_there_are():
    assert agent_spec("qlearning") == "agents.qlearning:QLearning"
    assert agent_spec("somewhere:Agent") == "somewhere:Agent"
    assert "no agent is called 'qlerning'; there are qlearning, dqn" in complaint(agent_spec, "qlerning")


def test_a_missing_file(tmp_path):
    assert "nowhere.yaml" in complaint(load_experiment, tmp_path / "nowhere.yaml")


@pytest.mark.parametrize("key", ["regularization", "environment.regularization"])
def test_overrides_by_bare_and_dotted_key(load, key):
    run = resize(load("environment: {regularization: 0.5, noise: 0.1}"), {key: 0.25}, "--set").run
    assert run.environment.regularization == 0.25
    assert run.environment.noise == 0.1


def test_overrides_of_several_sections():
    changed = override(RunConfig(), {"decisions": 9, "settings.learning_rate": 0.1, "tau_f": 0.4}, "--set")
    assert changed == RunConfig(
        decisions=9, settings={"learning_rate": 0.1}, parameters=CrawlerParameters(tau_f=0.4)
    )


def test_overrides_take_effect_together():
    """Either of the two alone is refused."""
    changed = override(RunConfig(), {"settle": 500, "duration": 600}, "--set").evaluation
    assert (changed.settle, changed.duration) == (500, 600)
    complaint(override, RunConfig(), {"settle": 500, "gait": -1}, "--set")


def test_another_size_changes_seeds_grid_and_values(load):
    experiment = load("seeds: 9\ngrid: {settings.a: [1, 2], environment.noise: [0, 0.1]}\ndecisions: 7")
    changes = {"seeds": "4-5", "settings.a": 3, "noise": [0.2, 0.3], "decisions": 6, "starts": 2}
    resized = resize(experiment, changes, "--set")
    assert (resized.seeds, resized.run.decisions, resized.run.evaluation.starts) == ((4, 5), 6, 2)
    assert resized.grid == {"settings.a": (3,), "environment.noise": (0.2, 0.3)}
    assert len(list(resized.runs())) == 4
    assert "--set: seeds" in complaint(resize, experiment, {"seeds": 0}, "--set")
    assert "--set: grid" in complaint(resize, experiment, {"grid": 5}, "--set")


def test_what_learns_nothing_still_learns_nothing_at_another_size(load):
    assert resize(load("decisions: 0"), {"decisions": 6}, "--set").run.decisions == 0


def test_an_ambiguous_bare_key_names_its_full_ones():
    message = complaint(override, RunConfig(), {"noise": 0.1}, "--set")
    assert "ambiguous; write environment.noise or evaluation.noise" in message


@pytest.mark.parametrize(
    ("key", "meant"),
    [("regularisation", "regularization"), ("environment.nois", "environment.noise"), ("agnt", "agent")],
)
def test_an_override_of_an_unknown_key(key, meant):
    assert f"did you mean {meant!r}?" in complaint(override, RunConfig(), {key: 1}, "--set")


def test_an_override_with_a_bad_value_says_so():
    assert "--set: environment.regularization" in complaint(
        override, RunConfig(), {"regularization": -1}, "--set"
    )


@pytest.mark.parametrize("word", ["decisions", "=3", "decisions=[1"])
def test_assignments_must_have_their_form(word):
    assert repr(word) in complaint(parse_assignments, [word])


def test_assignments_are_yaml():
    words = ["a=1", "b=0.5", "c=[0, 0.1]", "d=true", "e=x=y", " f = word "]
    assert parse_assignments(words) == {
        "a": 1, "b": 0.5, "c": [0, 0.1], "d": True, "e": "x=y", "f": "word"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("given", "seeds"),
    [
        (3, (0, 1, 2)),
        ("3", (0, 1, 2)),
        ("100-102", (100, 101, 102)),
        ("7-7", (7,)),
        ("3,5,8", (3, 5, 8)),
        ("5,", (5,)),
        ([4, 2], (4, 2)),
    ],
)
def test_seeds_as_number_range_or_list(load, given, seeds):
    assert parse_seeds(given) == seeds
    assert load(yaml.safe_dump({"seeds": given})).seeds == seeds


@pytest.mark.parametrize(
    "given",
    [
        0,
        -1,
        "0",
        "9-3",
        "3;4",
        "",
        "a",
        "²",
        2.5,
        True,
        None,
        [],
        [-1],
        [True],
        "3,3",
        10**6,
        "0-99999999999",
    ],
)
def test_what_seeds_cannot_be(given):
    with pytest.raises(ValueError, match="a number of them above 0 "):
        parse_seeds(given)


def test_a_grid_is_every_combination_over_every_seed(load):
    experiment = load("seeds: [4, 5]\ngrid: {settings.learning_rate: [0.1, 0.2], decisions: [1, 2, 3]}")
    found = [(run.settings["learning_rate"], run.decisions, seed) for run, seed in experiment.runs()]
    assert found == [(a, d, s) for a in (0.1, 0.2) for d in (1, 2, 3) for s in (4, 5)]


def test_a_grid_over_an_unknown_key_names_the_experiment(load):
    experiment = load("grid: {regularisation: [1]}")
    assert "mine: unknown key 'regularisation'" in complaint(list, experiment.runs())


def test_without_a_grid_there_is_one_run_a_seed(load):
    experiment = load("seeds: 100-101\ndecisions: 5")
    assert list(experiment.runs()) == [(experiment.run, 100), (experiment.run, 101)]


def test_a_resolved_configuration_reads_back_as_itself(load):
    run = load("environment: {regularization: 1e-5, time_limit: .inf}\nsettings: {learning_rate: 1e-7}").run
    assert load(to_yaml(run)).run == run


CONFIGS = sorted(config_folder().glob("*/*.yaml"))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_configuration_loads_and_expands(path: Path):
    experiment = (load_tuning if path.parent.name == "tuning" else load_experiment)(path)
    smoke = resize(experiment, smoke_changes(path.parent.name, experiment.name), "smoke")
    work = [sum(1 + run.decisions for run, _ in each.runs()) for each in (experiment, smoke)]
    assert 0 < work[1] < work[0] / 10 or not experiment.run.decisions
