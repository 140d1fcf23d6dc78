"""Where compiled code is kept."""

import os

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


def test_the_hash_sees_every_file(tmp_path):
    (tmp_path / "a.py").write_text("1")
    before = cache.source_hash(tmp_path)
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "b.py").write_text("2")
    between = cache.source_hash(tmp_path)
    (tmp_path / "a.py").write_text("3")
    assert len({before, between, cache.source_hash(tmp_path)}) == 3
