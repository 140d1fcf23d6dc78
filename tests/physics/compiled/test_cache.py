"""Where compiled code is kept."""

import os
import stat
from pathlib import Path

import pytest

from crawler_bench.physics.compiled import cache


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    monkeypatch.setenv("CRAWLER_BENCH_CACHE", str(tmp_path))
    cache.cache_folder.cache_clear()
    yield tmp_path
    cache.cache_folder.cache_clear()


def test_the_folder_is_named_after_the_sources(fresh):
    assert cache.cache_folder() == fresh / cache.KERNEL_HASH


def test_only_the_newest_versions_are_kept_and_nothing_else_is_touched(fresh):
    for age in range(12):
        (fresh / f"{age:016x}").mkdir()
        os.utime(fresh / f"{age:016x}", (1000 - age, 1000 - age))
    for name in ("mine", "0123456789abcdeX", "f" * 17):
        (fresh / name).mkdir()
    (fresh / ("a" * 16)).write_text("a file")
    cache.cache_folder()
    left = {each.name for each in fresh.iterdir()}
    versions = {f"{age:016x}" for age in range(cache.KEPT_VERSIONS - 1)} | {cache.KERNEL_HASH}
    assert left == versions | {"mine", "0123456789abcdeX", "f" * 17, "a" * 16}


def test_an_unwritable_place_is_not_insisted_on(fresh, monkeypatch):
    (fresh / "file").write_text("")
    monkeypatch.setenv("CRAWLER_BENCH_CACHE", str(fresh / "file"))
    monkeypatch.setattr(cache.tempfile, "gettempdir", lambda: str(fresh / "elsewhere"))
    folder = cache.cache_folder()
    assert folder.is_dir()
    assert folder.is_relative_to(fresh / "elsewhere")


def mode_of(folder) -> int:
    return stat.S_IMODE(folder.stat().st_mode)


def test_the_cache_is_the_users_alone(fresh):
    (fresh / cache.KERNEL_HASH).mkdir(mode=0o755)
    (fresh / cache.KERNEL_HASH / "index").write_text("ours")
    assert mode_of(cache.cache_folder()) == 0o700
    assert (cache.cache_folder() / "index").read_text() == "ours"


@pytest.mark.parametrize("mode", [0o777, 0o775])
def test_what_others_could_write_into_is_not_read(fresh, mode):
    planted = fresh / cache.KERNEL_HASH
    planted.mkdir()
    (planted / "index").write_text("anybody's")
    planted.chmod(mode)
    folder = cache.cache_folder()
    assert folder == planted
    assert mode_of(folder) == 0o700
    assert not list(folder.iterdir())


def test_a_folder_of_another_user_is_not_used_not_even_in_the_temporary_folder(fresh, monkeypatch):
    monkeypatch.setattr(cache.tempfile, "tempdir", str(fresh / "elsewhere"))
    (fresh / "elsewhere").mkdir()
    another = os.getuid() + 1
    for place in (fresh, fresh / "elsewhere" / f"crawler-bench-{another}"):
        (place / cache.KERNEL_HASH).mkdir(parents=True)
    monkeypatch.setattr(cache.os, "getuid", lambda: another)
    folder = cache.cache_folder()
    assert folder.parent == fresh / "elsewhere"
    assert not folder.name.startswith(f"crawler-bench-{os.getuid()}")
    assert mode_of(folder) == 0o700


def test_a_place_where_anybody_may_exchange_the_folder_is_not_used(fresh, monkeypatch):
    monkeypatch.setattr(cache.tempfile, "tempdir", str(fresh / "elsewhere"))
    (fresh / "elsewhere").mkdir()
    fresh.chmod(0o777)
    assert cache.cache_folder().is_relative_to(fresh / "elsewhere")


def test_a_link_is_not_followed(fresh, monkeypatch):
    monkeypatch.setattr(cache.tempfile, "tempdir", str(fresh / "elsewhere"))
    for name in ("elsewhere", "planted"):
        (fresh / name).mkdir()
    (fresh / cache.KERNEL_HASH).symlink_to(fresh / "planted")
    assert cache.cache_folder().is_relative_to(fresh / "elsewhere")


def test_the_hash_sees_every_file(tmp_path):
    (tmp_path / "a.py").write_text("1")
    before = cache.source_hash(tmp_path)
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "b.py").write_text("2")
    between = cache.source_hash(tmp_path)
    (tmp_path / "a.py").write_text("3")
    assert len({before, between, cache.source_hash(tmp_path)}) == 3


def test_what_the_hash_leaves_out_compiles_nothing():
    folder = Path(cache.__file__).parents[2] / "envs"
    left_out = {path for path in folder.rglob("*.py")} - set(cache.KERNEL_SOURCES)
    assert left_out
    for path in left_out:
        assert "kernel" not in path.read_text()
