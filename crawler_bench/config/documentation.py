"""What every key of a run means, in which unit, and where its default comes from.

It stands once, as the comment behind the field in the source: "meaning, unit [source]". A source is the
paper, [chosen] or [fitted]; a comment that begins with "reading:" says what the paper leaves open.
"""

import ast
import inspect
import io
import re
import textwrap
import tokenize
from dataclasses import MISSING, dataclass, fields, is_dataclass
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from crawler_bench.config.schema import RunConfig

# As the comments write them; the longest first, for "1 / tau_theta" ends in another unit.
UNITS = ("1 / tau_theta", "tau_theta", "k L", "L", "s")


@dataclass(frozen=True)
class Setting:
    """One key that `--set` takes.

    Attributes:
        key: dotted.
        default: None where there is none.
        unit: empty for a number without one, or a word.
        meaning: in words.
        source: of the default.
    """

    key: str
    default: Any
    unit: str
    meaning: str
    source: str


def run_settings() -> list[Setting]:
    """Every key of a run but the agent's own, in the order of the file format."""
    found = []
    for key, field in RunConfig.model_fields.items():
        default = field.get_default(call_default_factory=True)
        if isinstance(default, BaseModel) or is_dataclass(default):
            found += _section(f"{key}.", type(default))
        elif key != "settings":
            found.append(_setting(key, default, _comments(RunConfig)[key]))
    return found


def _section(prefix: str, model: type) -> list[Setting]:
    comments = _comments(model)
    if is_dataclass(model):
        defaults = {each.name: None if each.default is MISSING else each.default for each in fields(model)}
    else:
        declared: Any = model
        defaults = {
            name: None if field.default is PydanticUndefined else field.default
            for name, field in declared.model_fields.items()
        }
    return [_setting(prefix + name, default, comments[name]) for name, default in defaults.items()]


def _setting(key: str, default: Any, comment: str) -> Setting:
    """Take "meaning, unit [source]" apart."""
    body, _, bracket = comment.partition("[")
    source = bracket.rpartition("]")[0]
    if body.startswith("reading:"):
        body, source = body.removeprefix("reading:"), source or "a reading of the paper"
    body, unit = body.strip(), ""
    for each in UNITS:
        if found := re.search(rf"(^|, ){re.escape(each)}(?=[:,]|$)[:,]? ?", body):
            body, unit = f"{body[: found.start()]} {body[found.end() :]}".strip(), each
            break
    meaning = body or key.rpartition(".")[2].replace("_", " ")
    return Setting(key, default, unit, meaning, source or "chosen")


def _comments(model: type) -> dict[str, str]:
    """The comment behind each field of a class."""
    source = textwrap.dedent(inspect.getsource(model))
    lines: dict[int, str] = {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT and not token.string.startswith("# fmt"):
            lines[token.start[0]] = token.string.lstrip("# ")
    (definition,) = ast.parse(source).body
    assert isinstance(definition, ast.ClassDef)
    return {
        node.target.id: " ".join(lines[at] for at in _span(node) if at in lines)
        for node in definition.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }


def _span(node: ast.AnnAssign) -> range:
    return range(node.lineno, (node.end_lineno or node.lineno) + 1)
