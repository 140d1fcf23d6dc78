"""Configurations: YAML over typed defaults, overrides, grids, seeds, and one-line errors."""

from pathlib import Path

import pytest
import yaml

from crawler_bench.config import files, schema
from crawler_bench.config.files import load_experiment, parse_assignments
from crawler_bench.config.schema import ConfigError, EvaluationConfig, Experiment, RunConfig, override, resize
from crawler_bench.physics.parameters import CrawlerParameters


@pytest.fixture
def load(tmp_path):
    def loader(text: str) -> Experiment:
        (tmp_path / "mine.yaml").write_text(text)
        return load_experiment(tmp_path / "mine.yaml")

    return loader


def complaint(call, *arguments) -> str:
    """The one line of a ConfigError."""
    with pytest.raises(ConfigError) as caught:
        call(*arguments)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


def test_an_empty_file_is_all_defaults(load):
    assert load("") == Experiment(name="mine", run=RunConfig(), seeds=tuple(range(10)))
    assert load("").run.parameters == CrawlerParameters()


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


BAD_FILES = """
decision: 5 | unknown key 'decision'; did you mean 'decisions'?
environment: {regularisation: 0} | did you mean 'regularization'?
parameters: {friction_foward: 1} | did you mean 'friction_forward'?
evaluation: {warmup: 1} | did you mean 'warm_up'?
environment: {zzz: 1} | 'environment.zzz'; known are regularization, noise, episode_distance, time_limit
environment: {regularization: abc} | environment.regularization
environment: {regularization: .nan} | environment.regularization
environment: {regularization: -0.1} | environment.regularization
environment: {episode_distance: .nan} | environment.episode_distance
environment: {time_limit: 0} | environment.time_limit
environment: 3 | environment
decisions: 1.5 | decisions
decisions: -1 | decisions
decisions: 1e30 | decisions
crawlers: 100000 | crawlers
agent: 4 | agent
settings: 4 | settings
parameters: {n_segments: 1} | n_segments
parameters: {n_segments: 200000} | n_segments must be at most 1000
parameters: {damping: -1} | damping
parameters: {damping: .nan} | damping
parameters: {damping: [1]} | damping
parameters: {head_muscle: soft} | head_muscle
parameters: {decision_interval: 500} | duration and gait must be at least one decision_interval
evaluation: {starts: 0} | evaluation.starts
evaluation: {duration: 1e9} | does not fit in memory
evaluation: {gait: 0} | gait
evaluation: {noise: []} | evaluation.noise
evaluation: {noise: [0.1, 0.2]} | evaluation.noise
evaluation: {noise: [0, 0.2, 0.1]} | evaluation.noise
evaluation: {noise: [0, .nan]} | evaluation.noise
evaluation: {noise: [0, .inf]} | evaluation.noise
seeds: 0 | seeds
seeds: [3, 3] | seeds
run: {decisions: 5} | run
grid: {decisions: 5} | grid.decisions
{decisions: 1, decisions: 2} | 'decisions' stands twice
settings: {a: 1, a: 2} | 'a' stands twice
settings: {a: &a [1], b: *a} | aliases
- 1 | mapping
3 | mapping
decisions: [ | not YAML
"""


@pytest.mark.parametrize("line", BAD_FILES.strip().splitlines())
def test_a_bad_file_names_itself_and_what_is_wrong(load, line):
    text, _, said = line.partition(" | ")
    message = complaint(load, text)
    assert "mine.yaml" in message
    assert said in message


def test_a_number_or_a_nesting_beyond_all_bounds_is_said_in_one_line(load):
    huge = {"head_muscle": "external", "n_segments": 10**400}
    assert "too large" in complaint(override, RunConfig(), huge, "--set")
    assert "is not YAML" in complaint(load, "[" * 5000)


def test_a_misspelt_agent_names_those_there_are():
    assert files.agent_spec("qlearning") == "agents.qlearning:QLearning"
    assert files.agent_spec("somewhere:Agent") == "somewhere:Agent"
    assert "'qlerning'; did you mean 'qlearning'?" in complaint(files.agent_spec, "qlerning")


def test_a_missing_file(tmp_path):
    assert "nowhere.yaml" in complaint(load_experiment, tmp_path / "nowhere.yaml")


@pytest.mark.parametrize("key", ["regularization", "environment.regularization"])
def test_overrides_by_bare_and_dotted_key(load, key):
    run = load("environment: {regularization: 0.5, noise: 0.1}").run
    changed = override(run, {key: 0.25, "decisions": 9, "settings.learning_rate": 0.1, "tau_f": 0.4}, "--set")
    assert changed.environment == run.environment.model_copy(update={"regularization": 0.25})
    assert (changed.decisions, changed.settings) == (9, {"learning_rate": 0.1})
    assert changed.parameters == CrawlerParameters(tau_f=0.4)


def test_overrides_take_effect_together():
    """Either of the two alone is refused."""
    changed = override(RunConfig(), {"decision_interval": 500, "duration": 500, "gait": 500}, "--set")
    assert changed.evaluation.duration == changed.parameters.decision_interval == 500
    complaint(override, RunConfig(), {"decision_interval": 500, "duration": 500}, "--set")


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("regularisation", "did you mean 'regularization'?"), ("agnt", "did you mean 'agent'?"),
        ("environment.nois", "did you mean 'environment.noise'?"), ("epsilon", "here it is 'regularization'"),
        ("noise", "ambiguous; write environment.noise or evaluation.noise"),
        ("regularization", "--set: environment.regularization"),
    ],
)  # fmt: skip
def test_a_bad_override_says_what_is_wrong(key, said):
    assert said in complaint(override, RunConfig(), {key: -1}, "--set")


def test_another_size_changes_seeds_grid_and_values(load):
    experiment = load("seeds: 9\ngrid: {settings.a: [1, 2], environment.noise: [0, 0.1]}\ndecisions: 7")
    changes = {"seeds": "4-5", "settings.a": 3, "noise": [0.2, 0.3], "decisions": 6, "starts": 2}
    resized = resize(experiment, changes, "--set")
    assert (resized.seeds, resized.run.decisions, resized.run.evaluation.starts) == ((4, 5), 6, 2)
    assert resized.grid == {"settings.a": (3,), "environment.noise": (0.2, 0.3)}
    assert len(list(resized.runs())) == 4
    assert "--set: seeds" in complaint(resize, experiment, {"seeds": 0}, "--set")
    assert "--set: grid" in complaint(resize, experiment, {"grid": 5}, "--set")
    assert resize(load("decisions: 0"), {"decisions": 6}, "--set").run.decisions == 0  # it learns nothing


@pytest.mark.parametrize("word", ["decisions", "=3", "decisions=[1"])
def test_assignments_must_have_their_form(word):
    assert repr(word) in complaint(parse_assignments, [word])


def test_assignments_are_yaml():
    words = ["a=1", "b=0.5", "c=[0, 0.1]", "d=true", "e=x=y", " f = word "]
    found = {"a": 1, "b": 0.5, "c": [0, 0.1], "d": True, "e": "x=y", "f": "word"}
    assert parse_assignments(words) == found


@pytest.mark.parametrize(
    ("given", "seeds"),
    [
        (3, (0, 1, 2)), ("3", (0, 1, 2)), ("100-102", (100, 101, 102)), ("7-7", (7,)), ("3,5,8", (3, 5, 8)),
        ("5,", (5,)), ([4, 2], (4, 2)),
    ],
)  # fmt: skip
def test_seeds_as_number_range_or_list(load, given, seeds):
    assert schema.parse_seeds(given) == seeds
    assert load(yaml.safe_dump({"seeds": given})).seeds == seeds


NO_SEEDS = [0, -1, "0", "9-3", "3;4", "", "a", "²", 2.5, True, None, [], [-1], [True], "3,3", "0-99999999999"]


@pytest.mark.parametrize("given", [*NO_SEEDS, 10**6])
def test_what_seeds_cannot_be(given):
    with pytest.raises(ValueError, match="a number of them above 0 "):
        schema.parse_seeds(given)


def test_a_grid_is_every_combination_over_every_seed(load):
    experiment = load("seeds: [4, 5]\ngrid: {settings.learning_rate: [0.1, 0.2], decisions: [1, 2, 3]}")
    found = [(run.settings["learning_rate"], run.decisions, seed) for run, seed in experiment.runs()]
    assert found == [(a, d, s) for a in (0.1, 0.2) for d in (1, 2, 3) for s in (4, 5)]
    wrong = load("grid: {regularisation: [1]}")
    assert "mine: unknown key 'regularisation'" in complaint(list, wrong.runs())


def test_without_a_grid_there_is_one_run_per_seed(load):
    experiment = load("seeds: 100-101\ndecisions: 5")
    assert list(experiment.runs()) == [(experiment.run, 100), (experiment.run, 101)]


def test_a_resolved_configuration_reads_back_as_itself(load):
    run = load("environment: {regularization: 1e-5, time_limit: .inf}\nsettings: {learning_rate: 1e-7}").run
    assert load(schema.to_yaml(run)).run == run


CONFIGS = sorted(files.config_folder().glob("*/*.yaml"))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_configuration_expands_and_its_smoke_preset_is_small(path: Path):
    experiment = (files.load_tuning if path.parent.name == "tuning" else load_experiment)(path)
    smoke = resize(experiment, files.smoke_changes(path.parent.name, experiment.name), "smoke")
    full, small = (sum(1 + run.decisions for run, _ in each.runs()) for each in (experiment, smoke))
    assert 0 < small < full / 10 or not experiment.run.decisions
