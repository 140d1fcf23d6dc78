"""Experiments as data: values over typed defaults, checked key by key.

A `RunConfig` and a seed decide one training run and its evaluation; an `Experiment` is a family of runs.
"""

import difflib
import itertools
import math
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeVar

import yaml
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from crawler_bench.config.errors import ConfigError, nearest
from crawler_bench.config.wording import describe
from crawler_bench.physics.parameters import CrawlerParameters

PAPER_NAMES = {
    "epsilon": "regularization",
    "alpha": "settings.learning_rate",
    "gamma": "settings.discount",
    "N": "n_segments",
}


# Beyond these a run ends for want of memory, or never.
MOST_DECISIONS = 10**9
MOST_CRAWLERS = 10_000
MOST_SEGMENTS = 1000
MOST_SEEDS = 10_000
MOST_SAMPLES = 10**7  # of a node in one crawl, 32 bytes each


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)


class EnvironmentConfig(_Model):
    """The task: arguments of `CrawlerEnv` beside the parameters."""

    regularization: float = Field(0.01, ge=0, allow_inf_nan=False)  # epsilon [M20, eq. 11]
    noise: float = Field(0.0, ge=0, allow_inf_nan=False)  # amplitude s while learning [M20, Fig. 3C]
    episode_distance: float = Field(8.83, gt=0)  # after which an episode ends, L [chosen; "a fixed distance"]
    time_limit: float = Field(4000.0, gt=0)  # after which an episode ends, tau_theta [chosen]
    keyhole: Literal["index", "one-hot", "strain", "state"] = "index"  # what is observed [envs/keyholes.py]

    @property
    def task(self) -> dict[str, Any]:
        """Everything but the keyhole, as the environments take it."""
        return {name: value for name, value in self if name != "keyhole"}


class EvaluationConfig(_Model):
    """How a trained policy is measured: frozen, from several starts, at several amplitudes of noise."""

    starts: int = Field(12, ge=1)  # from how many states each policy crawls [chosen]
    warm_up: float = Field(100.0, ge=0, allow_inf_nan=False)  # of random action first, tau_theta [chosen]
    duration: float = Field(400.0, gt=0, allow_inf_nan=False)  # of the policy, tau_theta [chosen]
    settle: float = Field(800.0, ge=0, allow_inf_nan=False)  # before a gait is described, tau_theta [chosen]
    gait: float = Field(400.0, gt=0, allow_inf_nan=False)  # that is described, tau_theta [chosen]
    noise: tuple[float, ...] = (0.0, 0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)  # amplitudes s [M20, Fig. 3C]
    mode: Literal["deterministic", "stochastic"] = "deterministic"  # which policy, of two [chosen]
    seed: int = Field(2020, ge=0)  # of starts and noise, the same for every policy [chosen]

    @field_validator("noise")
    @classmethod
    def _starts_without_noise(cls, noise: tuple[float, ...]) -> tuple[float, ...]:
        if not noise or noise[0] != 0 or any(not a < b < math.inf for a, b in itertools.pairwise(noise)):
            raise ValueError("noise amplitudes start with 0 and increase")
        return noise


class RunConfig(_Model):
    """Everything but the seed that decides one training run and its evaluation."""

    agent: str = "qlearning"  # a name of `crawler-bench list`, or module:Class [M20]
    settings: dict[str, Any] = {}  # of the agent's class
    decisions: int = Field(800_000, ge=0, le=MOST_DECISIONS)  # to learn from, all crawlers together [chosen]
    crawlers: int = Field(1, ge=1, le=MOST_CRAWLERS)  # that a deep agent learns from at once [chosen]
    environment: EnvironmentConfig = EnvironmentConfig()
    parameters: CrawlerParameters = CrawlerParameters()
    evaluation: EvaluationConfig = EvaluationConfig()

    @model_validator(mode="after")
    def _can_be_run(self) -> "RunConfig":
        segments, interval = self.parameters.n_segments, self.parameters.decision_interval
        if segments > MOST_SEGMENTS:
            raise ValueError(f"n_segments must be at most {MOST_SEGMENTS}")
        evaluation = self.evaluation
        if min(evaluation.duration, evaluation.gait) < interval:
            raise ValueError(f"duration and gait must be at least one decision_interval, {interval:g}")
        longest = evaluation.warm_up + max(evaluation.duration, evaluation.settle + evaluation.gait)
        if longest / interval * (segments + 1) > MOST_SAMPLES:
            raise ValueError(
                f"an evaluation over {longest:g} tau with {segments} segments does not fit in memory: "
                f"(time / decision_interval) * (n_segments + 1) must be at most {MOST_SAMPLES:,}"
            )
        return self


def parse_seeds(value: Any) -> Any:
    """Read seeds: a number of them (from 0), a range "100-109", or a list "3,5,8" of different ones.

    Raises:
        ValueError: if it is none of these.
    """
    if isinstance(value, str) and re.fullmatch(r"\s*[0-9]{1,18}\s*", value):
        value = int(value)
    if isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= MOST_SEEDS:
        return tuple(range(value))
    if isinstance(value, str):
        span = re.fullmatch(r"\s*(\d{1,18})\s*-\s*(\d{1,18})\s*", value)
        if span and 0 <= int(span[2]) - int(span[1]) < MOST_SEEDS:
            return tuple(range(int(span[1]), int(span[2]) + 1))
        if re.fullmatch(r"\s*\d{1,18}(\s*,\s*\d{1,18})*\s*,?\s*", value):
            value = [int(word) for word in value.split(",") if word.strip()]
    if (
        isinstance(value, list | tuple)
        and value
        and all(isinstance(seed, int) and not isinstance(seed, bool) and seed >= 0 for seed in value)
        and len(set(value)) == len(value)
    ):
        return tuple(value)
    twice = [str(seed) for seed in value if list(value).count(seed) > 1] if isinstance(value, list) else []
    raise ValueError(
        (f"{twice[0]} stands twice: " if twice else "")
        + f"seeds are a number of them above 0 (to {MOST_SEEDS}), a range like 100-109, or a list like 3,5,8"
    )


Seeds = Annotated[tuple[int, ...], BeforeValidator(parse_seeds)]


class Experiment(_Model):
    """A run repeated over seeds and, if there is a grid, over every combination of its values."""

    name: str
    run: RunConfig = RunConfig()
    seeds: Seeds = tuple(range(10))
    grid: dict[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = {}  # dotted key: values

    def runs(self) -> Iterator[tuple[RunConfig, int]]:
        """Every run of the experiment, with its seed."""
        for values in itertools.product(*self.grid.values()):
            run = override(self.run, dict(zip(self.grid, values, strict=True)), self.name)
            for seed in self.seeds:
                yield run, seed


class Range(_Model):
    """What a tuned value may be: one of `values`, or a number from `low` to `high`."""

    start: Any  # tried first
    values: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    log: bool = False  # drawn evenly on a logarithmic scale


class Tuning(Experiment):
    """A search for the settings that earn an experiment's runs the highest reward."""

    trials: int = Field(12, ge=1)
    space: dict[str, Range] = Field(min_length=1)  # dotted key: what it may be


Built = TypeVar("Built", bound=_Model)
Resized = TypeVar("Resized", bound=Experiment)


def override(run: RunConfig, overrides: Mapping[str, Any], where: str) -> RunConfig:
    """Replace single values by dotted key; a bare key that only one section has will do."""
    content = to_mapping(run)
    for key, value in overrides.items():
        *sections, last = _full_key(content, key, where).split(".")
        target = content
        for section in sections:
            target = target[section]
        target[last] = value
    return build(RunConfig, content, where)


def resize(experiment: Resized, changes: Mapping[str, Any], where: str) -> Resized:
    """An experiment with other values.

    Args:
        experiment: the experiment, or the search.
        changes: values of its run by dotted or bare key, and of its own fields (seeds, grid, trials). A value
            that the grid varies varies no longer, or over the list given; what learns from no decisions keeps
            doing so.
        where: what an error names.

    Raises:
        ConfigError: naming the key and what is allowed or was probably meant.
    """
    fields = type(experiment).model_fields.keys() - {"name", "run"}
    of_run = {key: value for key, value in changes.items() if key not in fields}
    own = {key: value for key, value in changes.items() if key in fields}
    resized = build(type(experiment), to_mapping(experiment) | own, where)
    if not resized.run.decisions:
        of_run.pop("decisions", None)
    grid = dict(resized.grid)
    for varied in grid:
        for key in (varied, varied.rpartition(".")[2]):
            if key in of_run:
                value = of_run.pop(key)
                grid[varied] = tuple(value) if isinstance(value, list) else (value,)
    return resized.model_copy(update={"run": override(resized.run, of_run, where), "grid": grid})


def to_mapping(model: BaseModel) -> dict[str, Any]:
    """Plain nested values, as YAML and JSON hold them."""
    mapping: dict[str, Any] = model.model_dump(mode="json")
    return mapping


def to_yaml(model: BaseModel) -> str:
    """The resolved configuration, every default written out."""
    return yaml.safe_dump(to_mapping(model), sort_keys=False)


def _full_key(content: dict[str, Any], key: str, where: str) -> str:
    if key.startswith("settings.") and key.count(".") == 1:
        return key  # the agent's class knows its settings
    keys = [name for name in content if name != "settings"]
    dotted = [
        f"{section}.{name}"
        for section in keys
        if isinstance(content[section], dict)
        for name in content[section]
    ]
    matches = [full for full in [*keys, *dotted] if key in (full, full.partition(".")[2])]
    if len(matches) == 1:
        return matches[0]
    if matches:
        raise ConfigError(f"{where}: {key!r} is ambiguous; write {' or '.join(matches)}")
    if key in PAPER_NAMES:
        raise ConfigError(f"{where}: unknown key {key!r}; here it is {PAPER_NAMES[key]!r}")
    bare = [full.partition(".")[2] for full in dotted]
    close = difflib.get_close_matches(key, [*keys, *bare, *dotted], n=1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}?" if close else f"known are {', '.join([*keys, *dotted])}"
    raise ConfigError(f"{where}: unknown key {key!r}; {hint} (an agent's own are settings.NAME)")


def build(model: type[Built], content: Mapping[str, Any], where: str) -> Built:
    """Check values against a model.

    Raises:
        ConfigError: naming where, the key and what is allowed or was probably meant.
    """
    try:
        return model.model_validate(content)
    except OverflowError:
        raise ConfigError(f"{where}: a number in it is too large") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        loc = first["loc"][1:] if first["loc"][:1] == ("run",) else first["loc"]
        place = [str(part) for part in loc]
        if first["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
            names = _names_at(first["loc"][:-1], model)
            raise ConfigError(
                f"{where}: unknown key {'.'.join(place)!r}{nearest(place[-1], names)}"
            ) from None
        given = "" if isinstance(first["input"], dict) else f" (given: {first['input']!r})"
        own = first["type"] == "value_error"  # our words, a whole sentence
        said = f"{': ' if own else ' '}{describe(first)}" if place else describe(first)
        raise ConfigError(f"{where}: {'.'.join(place)}{said}{given}") from None


def _names_at(place: tuple[int | str, ...], model: Any) -> list[str]:
    """Names of the keys that a section has."""
    for part in place:
        if part == "CrawlerParameters":
            continue
        model = model.model_fields[part].annotation
    return list(model.model_fields if hasattr(model, "model_fields") else model.__dataclass_fields__)
