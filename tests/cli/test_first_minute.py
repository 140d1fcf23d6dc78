"""What a new user does first: help, version, lists, and what they cost before anything is computed."""

import json
import os
import re
import subprocess
import sys

import gymnasium
import pytest

from crawler_bench import __version__
from crawler_bench.config.documentation import run_settings
from crawler_bench.config.files import AGENTS, config_names, shipped_policies
from crawler_bench.config.schema import RunConfig, override
from crawler_bench.envs.keyholes import KEYHOLES
from crawler_bench.paper.claims import CLAIMS
from tests.cli.command import ROOT, crawler_bench, python

COMMANDS = (
    "reproduce readings train evaluate render tune benchmark certify watch report reproduce-cell verify list "
    "settings doctor warmup"
).split()

LOADED = """
import sys
from crawler_bench.cli import main
for words in {commands}:
    sys.argv = ["crawler-bench", *words]
    try:
        main()
    except SystemExit as ended:
        assert ended.code == {code}, ended.code
heavy = [name for name in {forbidden} if name in sys.modules]
assert not heavy, heavy
"""
PHYSICS = ("numba", "scipy.stats", "pandas", "matplotlib", "torch")
EVERYTHING = ("numpy", "gymnasium", *PHYSICS)
MISSPELT = [
    ["train", "nope"], ["train", "qlearning", "--config", "nope"], ["benchmark", "--agent", "nope"],
    ["benchmark", "--only", "nope"], ["tune", "nope"], ["settings", "nope"], ["reproduce", "--claim", "nope"],
    ["render", "nope"], ["evaluate", "nope"], ["reproduce", "--set", "nope=1"], ["train", "ppo", "--seeds="],
    ["watch", "nope"], ["verify", "nope"], ["certify", "--results", "nope"],
]  # fmt: skip


@pytest.mark.parametrize(
    ("commands", "code", "forbidden"),
    [
        ([["--help"], ["--version"], *([command, "--help"] for command in COMMANDS)], 0, EVERYTHING),
        ([["list"], ["settings"]], 0, PHYSICS),
        (MISSPELT, 2, PHYSICS),
        ([["doctor"]], 0, ("torch", "stable_baselines3", "pandas", "matplotlib", "pygame")),
    ],
    ids=["help", "lists", "misspelt", "doctor"],
)
def test_nothing_heavy_is_imported_for_an_answer(commands, code, forbidden, tmp_path):
    done = python(LOADED.format(commands=commands, code=code, forbidden=forbidden), tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]


def test_every_command_and_every_option_is_described():
    page = (ROOT / "docs" / "commands.md").read_text()
    assert sorted(re.findall(r"^\| `crawler-bench ([a-z-]+)", page, re.MULTILINE)) == sorted(COMMANDS)
    for command in COMMANDS:
        options = set(re.findall(r"^ +(--[a-z-]+)", crawler_bench(command, "--help")[1], re.MULTILINE))
        missing = {option for option in options - {"--help"} if option not in page}
        assert not missing, f"{command}: {missing}"


def test_help_on_every_level():
    top = crawler_bench("--help")[1]
    for command in COMMANDS:
        assert f" {command} " in top
        assert f"Usage: crawler-bench {command} " in crawler_bench(command, "--help")[1]


FIRST_NOTES = """
import sys
from crawler_bench.cli import main
from crawler_bench.cli.terminal import console
def note(text, *_, **__):
    print(text, [name for name in ("pandas", "numba", "torch") if name in sys.modules])
    sys.exit(7)
console.notes.print = note
for words in {commands}:
    sys.argv = ["crawler-bench", *words]
    try:
        main()
    except SystemExit as ended:
        assert ended.code == 7, words
"""
LONG = {
    "train ppo": "training ppo, run folders in results/runs",
    "evaluate regularized": "measuring 1 trained policy",
    "render regularized": "filming regularized, pictures and films in results/rendered/regularized",
    "reproduce --preset smoke": "reproducing the paper, results in results/smoke",
    "benchmark --preset smoke": "comparing agents, results in results/benchmark-smoke",
    "benchmark --preset smoke --only ppo": "comparing agents, results in results/benchmark-changed",
    "tune qlearning --preset smoke": "tuning qlearning in 6 trials, results in results/tuning-smoke",
    "readings --preset smoke": "running readings of the paper, results in results/readings-smoke",
}


def test_long_commands_say_what_they_will_do_and_where_before_they_import_anything(tmp_path):
    done = python(FIRST_NOTES.format(commands=[line.split() for line in LONG]), tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.splitlines() == [f"{said} []" for said in LONG.values()]


def test_the_version_is_printed():
    assert crawler_bench("--version")[:2] == (0, f"crawler-bench {__version__}\n")


def test_list_as_json_holds_what_the_list_names():
    code, out, _ = crawler_bench("list", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["agents"].items() >= AGENTS.items()
    assert found["configurations"] == config_names()
    assert found["policies"] == list(shipped_policies())
    assert all(gymnasium.spec(name) for name in found["environments"])
    assert len(found["environments"]) == len(KEYHOLES)
    assert list(found["claims"]) == [claim.name for claim in CLAIMS]
    text = crawler_bench("list")[1]
    for names in found.values():
        assert all(name in text for name in names)


def test_doctor_as_json_says_what_was_looked_at():
    code, out, _ = crawler_bench("doctor", "--json")
    found = {each["what"]: each for each in json.loads(out)}
    assert code == 0
    assert all(each["ok"] for each in found.values())
    assert {"numpy", "agents", "environment", "configurations"} < set(found)


def test_doctor_that_imports_finds_a_broken_package(tmp_path):
    (tmp_path / "seaborn.py").write_text("raise RuntimeError('half of it is missing')")
    code = "import sys; sys.argv[1:] = ['doctor', '--imports']; import crawler_bench.cli.__main__"
    done = python(code, tmp_path, tmp_path)
    assert done.returncode == 1
    assert "PROBLEM seaborn: RuntimeError: half of it is missing" in done.stdout


def test_every_key_that_set_takes_is_listed_with_default_unit_and_source():
    found = {each["key"]: each for each in json.loads(crawler_bench("settings", "--json")[1])}
    for key, each in found.items():
        if key != "agent":
            override(RunConfig(), {key: each["default"]}, "test")  # whichever --set does not know, fails
        assert each["meaning"], key
        assert each["source"], key
    sections = {key.partition(".")[0] for key in found}
    assert sections == set(RunConfig.model_fields) - {"settings"}
    assert len(found) == len(run_settings()) > 30
    assert found["parameters.dt"]["unit"] == "tau_theta"
    assert found["parameters.friction_forward"]["unit"] == "k L"
    assert found["environment.episode_distance"]["unit"] == "L"
    text = crawler_bench("settings")[1]
    assert all(key in text for key in found)


def test_the_settings_of_an_agent_are_those_of_its_class():
    found = {each["key"]: each for each in json.loads(crawler_bench("settings", "qlearning", "--json")[1])}
    assert found["settings.discount"]["default"] == 0.95
    assert found["settings.discount"]["meaning"].startswith("gamma")
    assert "settings.env" not in found
    assert not [
        key for key in json.loads(crawler_bench("settings", "wave", "--json")[1]) if "settings." in key
    ]


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("train ql", "qlearning"), ("render unr", "unregularized"), ("tune pp", "ppo"), ("sett", "settings"),
        ("train --config paper/r", "paper/regularized"), ("reproduce --claim nearest", "nearest_neighbour"),
    ],
)  # fmt: skip
def test_a_shell_completes_names(line, offered, tmp_path):
    words = f"crawler-bench {line}"
    environment = os.environ | {
        "PYTHONPATH": str(ROOT), "_CRAWLER_BENCH_COMPLETE": "complete_bash", "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }  # fmt: skip
    command = [sys.executable, "-m", "crawler_bench.cli"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [offered]
