"""Names that a shell completes, and what the commands make of them."""

from pathlib import Path


def agents() -> list[str]:
    """Names of agents."""
    from crawler_bench.config.files import registered_agents

    return list(registered_agents())


def configs() -> list[str]:
    """Names of configurations, as `list` prints them."""
    from crawler_bench.config.files import config_names

    return config_names()


def entries() -> list[str]:
    """Names of the entries of the comparison."""
    return [name.partition("/")[2] for name in configs() if name.startswith("benchmark/")]


def searches() -> list[str]:
    """Names of the searches of `tune`."""
    return [name.partition("/")[2] for name in configs() if name.startswith("tuning/")]


def claims() -> list[str]:
    """Names of claims."""
    from crawler_bench.paper.claims import CLAIMS

    return [claim.name for claim in CLAIMS]


def policies() -> list[str]:
    """Names of the policies that come with the project."""
    from crawler_bench.config.files import shipped_policies

    return list(shipped_policies())


def find_run(word: str) -> Path:
    """A run folder or a policy file: the one at a path, or the one that a name means.

    Raises:
        ConfigError: if there is neither.
    """
    from crawler_bench.config.errors import ConfigError, nearest
    from crawler_bench.config.files import shipped_policies

    path, known = Path(word), shipped_policies()
    is_run = all((path / name).is_file() for name in ("config.yaml", "manifest.json"))
    if is_run or path.is_file() or path.with_suffix(".json").is_file():
        return path
    if word in known:
        return known[word]
    if path.is_dir():
        raise ConfigError(
            f"{word} is not a finished run: a run folder holds config.yaml and manifest.json; "
            "`crawler-bench train` makes one"
        )
    raise ConfigError(
        f"{word} does not exist: give a run folder, as `crawler-bench train` prints it, a policy file, or "
        f"the name of a policy{nearest(word, list(known))}"
    )
