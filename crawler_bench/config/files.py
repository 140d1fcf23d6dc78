"""Names of experiments and agents, experiments as YAML files, and single values from the command line."""

import re
from collections.abc import Hashable, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, TypeVar

import yaml

from crawler_bench.config.errors import ConfigError, nearest
from crawler_bench.config.schema import Experiment, RunConfig, Tuning, build

Kind = TypeVar("Kind", bound=Experiment)

AGENTS_GROUP = "crawler_bench.agents"  # entry points with which installed packages register agents
AGENTS = {
    "qlearning": "agents.qlearning:QLearning",
    "dqn": "agents.deep:DQN",
    "ppo": "agents.deep:PPO",
    "a2c": "agents.deep:A2C",
    "qrdqn": "agents.deep:QRDQN",
    "recurrent-ppo": "agents.deep:RecurrentPPO",
    "random": "agents.reference:Random",
    "still": "agents.reference:Still",
    "wave": "agents.reference:Wave",
}


def registered_agents() -> dict[str, str]:
    """Every known agent, ours and those of installed packages: name to "module:Class"."""
    others = {point.name: point.value for point in entry_points(group=AGENTS_GROUP)}
    return AGENTS | {name: spec for name, spec in others.items() if name not in AGENTS}


def agent_spec(name: str) -> str:
    """Turn the name of an agent into its "module:Class"; a "module:Class" stays as it is.

    Raises:
        ConfigError: if no agent has that name.
    """
    if ":" in name:
        return name
    known = AGENTS if name in AGENTS else registered_agents()
    if name not in known:
        raise ConfigError(
            f"no agent is called {name!r}{nearest(name, list(known))} (your own is named module:Class)"
        )
    return known[name]


class _Loader(yaml.SafeLoader):
    """YAML 1.1, but 1e-4 is a number, a key stands once, and nothing multiplies itself by an alias."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases (*name) are not read here: write the value out")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        keys = [self.construct_object(key) for key, _ in node.value]
        if twice := sorted({str(key) for key in keys if keys.count(key) > 1}):
            raise yaml.YAMLError(f"{twice[0]!r} stands twice in one mapping")
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def config_folder() -> Path:
    """Folder of the configurations that come with the project: the checkout's, else the installed copy."""
    package = Path(__file__).resolve().parents[1]
    checkout = package.parent / "configs"
    return checkout if checkout.is_dir() else package / "configs"


def config_names() -> list[str]:
    """Names of all configurations that come with the project: paper/regularized and so on."""
    return sorted(f"{path.parent.name}/{path.stem}" for path in config_folder().glob("*/*.yaml"))


def find_config(name: str) -> Path:
    """The configuration of a name, from wherever one stands, or the YAML file at a path.

    Raises:
        ConfigError: if there is neither.
    """
    path, known = Path(name), config_names()
    if path.is_file():
        return path
    if name in known:
        return config_folder() / f"{name}.yaml"
    if path.suffix in (".yaml", ".yml"):
        raise ConfigError(f"{name} cannot be read (no such file); `crawler-bench list` names configurations")
    raise ConfigError(f"no configuration is called {name!r}{nearest(name, known)} (your own is a FILE.yaml)")


def shipped_policies() -> dict[str, Path]:
    """Trained policies that come with the project, by name."""
    folder = Path(__file__).resolve().parents[1] / "policies"
    return {path.stem: path for path in sorted(folder.glob("*.json"))}


def load_experiment(path: Path, missing: Mapping[str, Any] | None = None) -> Experiment:
    """Read an experiment from YAML.

    Args:
        path: the file; a run folder's config.yaml is one, too.
        missing: values of what the file leaves out, in place of the defaults.

    Raises:
        ConfigError: naming the file, the key and what is allowed or was probably meant.
    """
    return _load(Experiment, path, missing or {})


def load_tuning(path: Path) -> Tuning:
    """Read a search from YAML, as `load_experiment` does."""
    return _load(Tuning, path, {})


def _load(kind: type[Kind], path: Path, missing: Mapping[str, Any]) -> Kind:
    content = read_mapping(path)
    if content.keys() == {"seed", "run"} and isinstance(content["run"], dict):  # what a run folder holds
        content = content["run"] | {"seeds": [content["seed"]]}
    content = dict(missing) | content
    names = [key for key in content if key in kind.model_fields and key not in ("name", "run")]
    own = {key: content.pop(key) for key in names}
    return build(kind, {"name": path.stem, "run": content} | own, str(path))


def smoke_changes(study: str, experiment: str = "") -> dict[str, Any]:
    """What the smoke preset changes in a study, or in one of its experiments, as `resize` takes it."""
    sections = read_mapping(config_folder() / "smoke.yaml")
    changes: dict[str, Any] = {}
    for name in ("every", study, f"{study}/{experiment}"):
        for key, value in sections.get(name, {}).items():
            of_run = isinstance(value, dict) and key in RunConfig.model_fields
            changes |= {f"{key}.{part}": each for part, each in value.items()} if of_run else {key: value}
    return changes


def read_mapping(path: Path) -> dict[str, Any]:
    """Read a YAML file that holds keys and values.

    Raises:
        ConfigError: if there is no such file, or it holds something else.
    """
    try:
        content = parse_yaml(path.read_text())
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be read ({error.strerror}); configurations are YAML files"
        ) from None
    except ValueError as error:
        raise ConfigError(f"{path} is not YAML: {' '.join(str(error).split())}") from None
    content = {} if content is None else content
    if not isinstance(content, dict):
        raise ConfigError(f"{path} must hold a mapping of keys to values, not a {type(content).__name__}")
    return content


def parse_yaml(text: str) -> Any:
    """The value that YAML describes.

    Raises:
        ValueError: if it is not YAML.
    """
    try:
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, RecursionError, OverflowError) as error:
        raise ValueError(str(error)) from None


def parse_assignments(assignments: list[str]) -> dict[str, Any]:
    """Turn `key=value` words into a mapping; values are read as YAML."""
    parsed = {}
    for word in assignments:
        key, equals, value = word.partition("=")
        if not equals or not key:
            raise ConfigError(f"--set {word!r} is not of the form key=value")
        try:
            parsed[key.strip()] = parse_yaml(value)
        except ValueError:
            raise ConfigError(f"--set {word!r}: the value is not YAML") from None
    return parsed
