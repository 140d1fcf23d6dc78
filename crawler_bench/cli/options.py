"""What the commands share: their options, and the agents by name."""

from pathlib import Path
from typing import Annotated, Any

import typer

RUNS = Path("results/runs")

Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override a value; may be repeated.")
]
Seeds = Annotated[
    str | None, typer.Option(help="How many seeds (10), which range (100-109) or which (3,5,8).")
]
Jobs = Annotated[int, typer.Option(min=0, help="Parallel processes; 0 is one a core.")]
Runs = Annotated[Path, typer.Option(help="Folder of finished runs; what is there is not run again.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print results and errors only.")]


def agents_package() -> Any:
    """Import our `agents`, which another package on PyPI is called as well."""
    import agents

    if not hasattr(agents, "ENTRY_POINT_GROUP"):
        raise ValueError(
            f"the package 'agents' that Python finds is not crawler-bench's but {agents.__file__}; "
            "uninstall that one (it may be openai-agents) or use a fresh virtual environment"
        )
    return agents


def agent_spec(name: str) -> str:
    """The "module:Class" of an agent, which can be imported."""
    spec: str = agents_package().agent_spec(name)
    agents_package().agent_class(spec)
    return spec
