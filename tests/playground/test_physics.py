"""The page's own crawler against the package's."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crawler_bench.physics.parameters import CrawlerParameters
from crawler_bench.report import playground
from tests.playground.conftest import PLAYGROUND, Visit

REPLAY = """([{ parameters, actions }, step]) => {
  const crawler = new Crawler(parameters, step), spikes = [];
  crawler.onSpike = (neuron, time) => spikes.push([neuron, time]);
  const observed = () => [[...crawler.u], crawler.observe(0, page.random)];
  const after = actions.map((action) => (crawler.decide(action), observed()));
  const [displacement, observations] = [0, 1].map((part) => after.map((each) => each[part]));
  return { displacement, observations, spikes: spikes.sort((a, b) => a[1] - b[1]) };
}"""


@pytest.fixture(scope="module")
def trajectories() -> list[dict[str, Any]]:
    return playground.record_trajectories()


def test_twenty_trajectories_agree_to_the_order_of_the_step(
    visit: Visit, trajectories: list[dict[str, Any]]
) -> None:
    assert len(trajectories) == 20
    errors = []
    for trajectory in trajectories:
        expected = np.array(trajectory["displacement"])
        row = []
        for step in (0.02, 0.01, 0.005):
            replayed = visit.run(REPLAY, [trajectory, step])
            row.append(np.abs(expected - replayed["displacement"]).max())
            assert [neuron for neuron, _ in replayed["spikes"]] == [n for n, _ in trajectory["spikes"]]
            times = [time for _, time in replayed["spikes"]]
            np.testing.assert_allclose(times, [time for _, time in trajectory["spikes"]], atol=1e-9)
            if step == 0.01:
                assert disagreements(trajectory, replayed["observations"]) == []
        errors.append(row)
    coarse, used, fine = np.array(errors).T
    assert used.max() < 2e-4
    moved = coarse > 0  # with literal friction nothing moves, in either implementation
    assert moved.sum() == 19
    assert (used[moved] < 0.5 * coarse[moved]).all()
    assert (fine[moved] < 0.5 * used[moved]).all()
    # Over all of them the order is two.
    assert np.log2(coarse[moved] / fine[moved]).mean() / 2 == pytest.approx(2.0, abs=0.3)


def disagreements(trajectory: dict[str, Any], observations: list[int]) -> list[int]:
    """Decisions after which the two do not sense the same segment, ties to within the error left out."""
    strains = np.diff(trajectory["displacement"], axis=1)
    if trajectory["parameters"]["observation"] == "most_stretched":
        strains = -strains
    first, second = np.sort(strains, axis=1)[:, :-3:-1].T
    differ = np.array(trajectory["observations"]) != observations
    return np.flatnonzero(differ & (first - second > 1e-3)).tolist()


def test_the_trajectories_are_worth_comparing(trajectories: list[dict[str, Any]]) -> None:
    assert min(len(each["spikes"]) for each in trajectories) > 40
    moved = [np.ptp(each["displacement"]) > 0.1 for each in trajectories]
    assert sum(moved) == 19
    backward = [(np.diff(each["displacement"], axis=0) < -1e-6).any() for each in trajectories]
    assert sum(backward) == 2  # nodes slide backward, too


def test_trajectories_can_be_written(tmp_path: Path) -> None:
    playground.write_trajectories(tmp_path / "trajectories.json", decisions=3)
    assert (tmp_path / "trajectories.json").stat().st_size > 5000


def test_the_diagonal_crawls_at_the_speed_of_the_engine(visit: Visit) -> None:
    """Over many starts: the gait has several cycles of nearly the same speed, some 2 % apart."""
    starts, duration = 48, 1000.0
    expected = playground.mean_speeds([list(range(10))], starts, duration)[0]
    speed = visit.run(
        """([starts, duration]) => {
          const { parameters } = page, crawler = new Crawler(parameters), random = seededRandom(0);
          const settle = Math.round(100 / parameters.decision_interval);
          const decisions = Math.round(duration / parameters.decision_interval);
          let distance = 0;
          for (let start = 0; start < starts; start++) {
            crawler.reset();
            for (let i = 0; i < settle; i++) crawler.decide(Math.floor(10 * random()));
            for (let i = 0; i < settle; i++) crawler.decide(crawler.observe(0, random));
            for (let i = 0; i < decisions; i++) distance += crawler.decide(crawler.observe(0, random));
          }
          return distance / starts / duration;
        }""",
        [starts, duration],
    )
    assert expected > 0.004
    assert speed == pytest.approx(expected, rel=0.01)


def test_forces_balance_whatever_the_guess(visit: Visit) -> None:
    """Eq. 1-3 hold at every node, and building up from rest finds the same motion."""
    worst, difference, backward = visit.run("""() => {
      const parameters = { ...DEFAULTS.parameters, friction_forward: 0.3, friction_backward: 0.6 };
      const crawler = new Crawler(parameters), random = seededRandom(1);
      const { forward, backward } = crawler.limits;
      let worst = 0, difference = 0, count = 0;
      for (let trial = 0; trial < 2000; trial++) {
        const strength = 40 * random() ** 2;
        crawler.meanForce.forEach((_, i, force) => (force[i] = random()));
        crawler.u.forEach((_, j, u) => (u[j] = strength * (random() - 0.5)));
        crawler.slip.forEach((_, j, slip) => (slip[j] = Math.floor(3 * random()) - 1));
        crawler.pull();
        crawler.balance();
        const { v, drag } = crawler;
        for (let j = 0; j < v.length; j++) {
          const degree = (j > 0) + (j + 1 < v.length), needed = crawler.holding(j) - degree * drag * v[j];
          const low = v[j] > 0 ? forward : -backward, high = v[j] < 0 ? -backward : forward;
          worst = Math.max(worst, low - needed, needed - high);
        }
        const found = [...v];
        count += found.some((velocity) => velocity < 0);
        crawler.balanceFromRest();
        difference = Math.max(difference, ...found.map((velocity, j) => Math.abs(velocity - v[j])));
      }
      return [worst, difference, count];
    }""")
    assert backward > 500
    assert worst < 1e-9
    assert difference < 1e-9


def test_defaults_are_those_of_the_package() -> None:
    written = (PLAYGROUND / "defaults.js").read_text(encoding="utf-8")
    assert written == playground.defaults_script(), "write it again with playground.defaults_script()"


def test_every_constant_is_selectable(visit: Visit) -> None:
    names = {field.name for field in fields(CrawlerParameters)} - set(playground.OF_THE_ENGINE)
    assert set(visit.run("Object.keys(FIELDS)")) == names
    assert set(visit.run("[...$('readings').elements].map(({ name }) => name)")) == names


def test_policies_are_what_their_buttons_say() -> None:
    policies = {name: [int(digit) for digit in digits] for name, digits in playground.POLICIES.items()}
    assert policies["regularized"] == list(range(10))
    assert len(set(policies["unregularized"])) < 10  # some muscles are never used
    # With other constants these are other tables: see playground.search_fastest, and the paper's runs.
    speeds = dict(zip(policies, playground.mean_speeds(list(policies.values())), strict=True))
    assert speeds["fastest"] > 1.1 * max(speeds["regularized"], speeds["unregularized"])
    assert speeds["unregularized"] > speeds["regularized"]


def test_a_search_climbs() -> None:
    found, speed = playground.search_fastest("0123456789", rounds=1)
    start, again = playground.mean_speeds([list(range(10)), [int(digit) for digit in found]])
    assert again == speed > 1.05 * start
