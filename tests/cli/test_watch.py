"""The window with a live crawler: what the keys do, and that it opens and closes."""

import numpy as np
import pytest

from crawler_bench.cli import watch
from crawler_bench.config.schema import RunConfig, override
from crawler_bench.gait.rollout import rollout
from crawler_bench.runs.live import KICK, Live, live
from crawler_bench.runs.policies.files import Policy, write_policy

pygame = pytest.importorskip("pygame")


@pytest.fixture
def wave():
    crawler = Live(RunConfig(), np.eye(10), 0)
    for _ in range(300):
        crawler.advance()
    return crawler


def key(name: str):
    return pygame.event.Event(pygame.KEYDOWN, key=getattr(pygame, f"K_{name}"))


def test_it_crawls_as_a_rollout_does(wave):
    """From its own start, which chance decides; so by speed."""
    record = rollout(RunConfig().parameters, np.eye(10), warm_up=20, duration=100, noise=0, start=(0,))
    expected = (record.centroid[-1] - record.centroid[200]) / (record.time[-1] - record.time[200])
    for _ in range(300):
        wave.advance()
    assert wave.speed == pytest.approx(expected, rel=0.3)
    assert wave.time == pytest.approx(600 * RunConfig().parameters.decision_interval)


def test_keys_change_noise_and_pace_and_close(wave):
    control = watch.Control()
    for name in ("UP", "UP", "DOWN", "RIGHT", "RIGHT", "LEFT", "SPACE"):
        control.obey(key(name), wave)
    assert wave.noise == pytest.approx(watch.NOISE_STEP)
    assert (control.decisions, control.paused, control.closed) == (2, True, False)
    control.obey(key("DOWN"), wave)
    control.obey(key("DOWN"), wave)
    assert wave.noise == 0
    control.obey(key("q"), wave)
    assert control.closed


def test_a_kick_compresses_one_segment_and_the_crawler_goes_on(wave):
    before = wave.env.nodes["displacement"].copy()
    watch.Control().obey(key("k"), wave)
    moved = wave.env.nodes["displacement"] - before
    assert sorted(set(np.round(moved, 12))) == [0.0, KICK]
    assert np.count_nonzero(np.diff(moved)) == 1
    for _ in range(100):
        wave.advance()
    assert np.isfinite(wave.displacement).all()


def test_the_window_opens_and_closes(tmp_path, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    run = override(RunConfig(), {"agent": "wave"}, "test")
    write_policy(Policy(run, 0, {"deterministic": np.eye(10)}), tmp_path / "wave.json")
    crawler = live(tmp_path / "wave.json", "deterministic", 0)
    watch._show(crawler, "wave", frames=3)
    assert crawler.time == pytest.approx(3 * run.parameters.decision_interval)
    pygame.display.quit()
