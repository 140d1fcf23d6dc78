"""What happens to a finished folder is noticed, and said with the name of the file."""

import json
import random
import shutil
from pathlib import Path

import pytest

from crawler_bench.runs.folders import checksums
from crawler_bench.runs.folders.checksums import MANIFEST, added_to, damage, identity, seal

FILES = {"learning.csv": "decisions,time\n0,0\n", "agent.json": "{}", "policies/a.json": "[1, 2]"}


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "run"
    for name, text in FILES.items():
        (made / name).parent.mkdir(parents=True, exist_ok=True)
        (made / name).write_text(text)
    (made / MANIFEST).write_text(json.dumps({"seed": 1, "run": "abc", "wall_clock_seconds": 0.5}))
    seal(made, "run")
    return made


def test_a_sound_folder_is_sound_under_its_name(folder):
    assert damage(folder) == damage(folder, "run") == damage(folder, "run", of="abc") == ""
    content = json.loads((folder / MANIFEST).read_text())
    assert content["seed"] == 1
    assert set(content["files"]) == set(FILES)
    assert f"{folder} holds what was made as run" in damage(folder, "another")
    assert f"{folder} was measured on another run" in damage(folder, of="xyz")


def test_a_folder_with_a_manifest_of_its_own_answers_for_itself(folder):
    before = identity(folder)
    for name in ("evaluation-1", ".partial-x"):
        (folder / name).mkdir()
        (folder / name / MANIFEST).write_text("{}")
    seal(folder, "run")
    assert identity(folder) == before
    (folder / "notes.txt").write_text("")
    assert damage(folder) == ""
    assert added_to(folder) == ["notes.txt"]


@pytest.mark.parametrize("name", FILES)
def test_every_kind_of_damage_names_its_file(folder, name):
    path = folder / name
    content = path.read_bytes()
    other = next(folder / each for each in FILES if each != name).read_bytes()
    for changed in (b"", content[:-1], content + b"\n", content.replace(content[:1], b"7"), other):
        path.write_bytes(changed)
        assert damage(folder) == f"{path} was changed after it was written"
    path.unlink()
    assert damage(folder) == f"{path} is missing"
    path.mkdir()
    assert damage(folder) == f"{path} is missing"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "is damaged"), ("{", "is damaged"), ("[]", "is damaged"), ("\xff", "is damaged"),
        ("[" * 10**5, "is damaged"), ("{}", "holds no checksums"), ('{"files": {}}', "was changed"),
        ('{"files": 5, "checksum": 5}', "was changed"),
    ],
)  # fmt: skip
def test_a_manifest_that_is_none(folder, content, said):
    (folder / MANIFEST).write_bytes(content.encode("latin-1"))
    assert said in damage(folder)
    assert "\n" not in damage(folder)
    (folder / MANIFEST).unlink()
    assert "is missing" in damage(folder)
    (folder / MANIFEST).mkdir()
    assert "is missing" in damage(folder)


@pytest.mark.parametrize("change", [{"wall_clock_seconds": 0.1}, {"files": {}}, {"seed": 2}, {"new": 1}])
def test_an_edited_manifest_is_noticed(folder, change):
    content = json.loads((folder / MANIFEST).read_text())
    (folder / MANIFEST).write_text(json.dumps(content | change))
    assert "was changed after it was written" in damage(folder)


@pytest.mark.parametrize("name", ["../outside", "/etc/hostname", "policies/../../outside"])
def test_no_manifest_leads_outside_its_folder(folder, name):
    (folder.parent / "outside").write_text("")
    content = json.loads((folder / MANIFEST).read_text())
    content["files"][name] = "0"
    content["checksum"] = checksums._of_manifest(content)
    (folder / MANIFEST).write_text(json.dumps(content))
    assert "which is outside of its folder" in damage(folder)


def test_no_byte_of_a_folder_can_be_changed_unnoticed(folder, tmp_path):
    """A byte of the manifest that says the same in another way, like a space, is harmless."""
    rng = random.Random(5)
    for number in range(300):
        copy = tmp_path / "copy"
        shutil.copytree(folder, copy)
        path = rng.choice(sorted(each for each in copy.rglob("*") if each.is_file()))
        content = bytearray(path.read_bytes())
        place = rng.randrange(len(content))
        match number % 3:
            case 0:
                content[place] ^= 1 << rng.randrange(8)
            case 1:
                del content[place]
            case 2:
                content.insert(place, rng.randrange(256))
        before = path.read_bytes()
        path.write_bytes(content)
        if not damage(copy) and bytes(content) != before:
            assert path.name == MANIFEST
            assert json.loads(content) == json.loads(before)
        shutil.rmtree(copy)


def test_all_of_a_folder_is_written_to_the_disk(folder, monkeypatch):
    synced: list[Path] = []
    monkeypatch.setattr(checksums, "sync", synced.append)
    seal(folder, "run")
    assert {path.name for path in synced} == {
        "run",
        "policies",
        "a.json",
        "learning.csv",
        "agent.json",
        MANIFEST,
    }
