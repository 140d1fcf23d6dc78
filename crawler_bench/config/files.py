"""Experiments as YAML files, and single values from the command line."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml

from crawler_bench.config.schema import ConfigError, Experiment, Tuning, build, override

Kind = TypeVar("Kind", bound=Experiment)


class _Loader(yaml.SafeLoader):
    """YAML 1.1, but 1e-4 is a number."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def config_folder() -> Path:
    """Folder of the configurations that come with the project: the checkout's, else the installed copy."""
    package = Path(__file__).resolve().parents[1]
    checkout = package.parent / "configs"
    return checkout if checkout.is_dir() else package / "configs"


def load_experiment(path: Path, overrides: Mapping[str, Any] | None = None) -> Experiment:
    """Read an experiment from YAML, with `--set` overrides on top.

    Raises:
        ConfigError: naming the file, the key and what is allowed or was probably meant.
    """
    return _load(Experiment, path, overrides)


def load_entry(path: Path, template: Experiment) -> Experiment:
    """Read what is to be compared; decisions, seeds and grid, where missing, are the template's."""
    missing = {"decisions": template.run.decisions, "seeds": template.seeds, "grid": template.grid}
    return _load(Experiment, path, None, missing)


def load_tuning(path: Path, overrides: Mapping[str, Any] | None = None) -> Tuning:
    """Read a search from YAML, as `load_experiment` does."""
    return _load(Tuning, path, overrides)


def _load(
    kind: type[Kind],
    path: Path,
    overrides: Mapping[str, Any] | None,
    missing: Mapping[str, Any] | None = None,
) -> Kind:
    content = _read_mapping(path)
    if content.keys() == {"seed", "run"} and isinstance(content["run"], dict):  # what a run folder holds
        content = content["run"] | {"seeds": [content["seed"]]}
    content = dict(missing or {}) | content
    names = [key for key in content if key in kind.model_fields and key not in ("name", "run")]
    own = {key: content.pop(key) for key in names}
    experiment = build(kind, {"name": path.stem, "run": content} | own, str(path))
    return experiment.model_copy(update={"run": override(experiment.run, overrides or {}, "--set")})


def load_overrides(path: Path) -> dict[str, Any]:
    """Read values that change runs, by dotted key, from YAML."""
    flat: dict[str, Any] = {}
    for key, value in _read_mapping(path).items():
        flat |= (
            {f"{key}.{name}": each for name, each in value.items()}
            if isinstance(value, dict)
            else {key: value}
        )
    return flat


def _read_mapping(path: Path) -> dict[str, Any]:
    try:
        content = yaml.load(path.read_text(), _Loader)
    except OSError as error:
        raise ConfigError(
            f"{path} cannot be read ({error.strerror}); configurations are YAML files"
        ) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not YAML: {' '.join(str(error).split())}") from None
    content = {} if content is None else content
    if not isinstance(content, dict):
        raise ConfigError(f"{path} must hold a mapping of keys to values, not a {type(content).__name__}")
    return content


def parse_assignments(assignments: list[str]) -> dict[str, Any]:
    """Turn `key=value` words into a mapping; values are read as YAML."""
    parsed = {}
    for word in assignments:
        key, equals, value = word.partition("=")
        if not equals or not key:
            raise ConfigError(f"--set {word!r} is not of the form key=value")
        try:
            parsed[key.strip()] = yaml.load(value, _Loader)
        except yaml.YAMLError:
            raise ConfigError(f"--set {word!r}: the value is not YAML") from None
    return parsed
