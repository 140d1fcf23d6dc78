"""The settings of an agent's own: what its class takes, with the defaults and the words of its docstring."""

import inspect
import re
from collections.abc import Iterator

from crawler_bench.config.documentation import Setting
from crawler_bench.runs.agent import agent_class

GIVEN = ("self", "env", "seed")  # by the harness
NOT_FROM_YAML = ("_init_setup_model",)


def agent_settings(name: str) -> list[Setting]:
    """Every setting of an agent, as `--set settings.NAME=VALUE` takes it.

    Args:
        name: a registered name or "module:Class".

    Raises:
        ConfigError: if that is not an agent.
    """
    found: dict[str, Setting] = {}
    for kind in _that_see_the_rest(agent_class(name)):
        words = _described(inspect.getdoc(kind) or "")
        for key, parameter in inspect.signature(kind.__init__).parameters.items():  # type: ignore[misc]
            if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
                continue
            if key in (*GIVEN, *NOT_FROM_YAML) or f"settings.{key}" in found:
                continue
            default = None if parameter.default is parameter.empty else parameter.default
            source = f"{kind.__module__}.{kind.__qualname__}"
            found[f"settings.{key}"] = Setting(f"settings.{key}", default, "", words.get(key, ""), source)
    return list(found.values())


def _that_see_the_rest(kind: type) -> Iterator[type]:
    """The classes whose __init__ is reached, as long as each hands on the keywords that it does not know."""
    for base in kind.__mro__:
        if "__init__" in vars(base):
            yield base
            known = inspect.signature(base.__init__).parameters.values()  # type: ignore[misc]
            if not any(each.kind is each.VAR_KEYWORD for each in known):
                return


def _described(doc: str) -> dict[str, str]:
    """Words for each argument, from a docstring in Google's style or in Sphinx's."""
    google = r"^ +(\w+): (.+(?:\n {6,}.+)*)"
    sphinx = r"^:param (\w+): (.+(?:\n +.+)*)"
    found = re.findall(google, doc, re.MULTILINE) + re.findall(sphinx, doc, re.MULTILINE)
    return {name: " ".join(words.split()) for name, words in found}
