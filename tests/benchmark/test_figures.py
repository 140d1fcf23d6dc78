"""All figures of a benchmark, drawn from hand-made frames; what is drawn is what was given."""

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from crawler_bench.benchmark.figures.curves import (
    learning_curves,
    noise_curves,
    softening,
    temperature_places,
)
from crawler_bench.benchmark.figures.looks import of_agents, places, truncate
from crawler_bench.benchmark.figures.policies import gaits, policy_matrices, trap_matrix
from crawler_bench.benchmark.figures.scores import cycle_durations, speeds
from crawler_bench.benchmark.keys import select
from crawler_bench.gait.record import Record
from crawler_bench.statistics import estimates

KEY = ["agent", "mode", "regularization", "seed"]
USUAL = (("ppo", "deterministic"), ("ppo", "stochastic"), ("random", "stochastic"), ("wave", "deterministic"))
CASES = {
    "usual": {},
    "one seed": {"pairs": USUAL[1:], "seeds": 1},
    "one mode": {"pairs": [("wave", "deterministic")]},
    "one regularization": {"regularizations": [0.02]},
    "three regularizations": {"pairs": USUAL[:2], "regularizations": [0.0, 0.01, 0.1]},
    "twelve unknown agents": {
        "pairs": [(f"{'a-rather-long-name-of-' * (i % 2)}agent-{i}", "deterministic") for i in range(12)],
        "regularizations": [0.0],
    },
    "two segments": {"pairs": USUAL[:2], "n": 2},
}


@pytest.fixture(autouse=True)
def _coarse_intervals(monkeypatch):
    monkeypatch.setattr(estimates, "RESAMPLES", 99)


def benchmark(pairs=USUAL, seeds=4, regularizations=(0.0, 0.01), n=10):
    """Frames as the benchmark holds them; only agents whose name holds an "a" have waves."""
    rng = np.random.default_rng(0)
    runs = pd.DataFrame(
        [(*pair, epsilon, seed) for pair in pairs for epsilon in regularizations for seed in range(seeds)],
        columns=KEY,
    )
    runs["speed"] = 0.006 * rng.random(len(runs))
    evaluations = runs.merge(pd.DataFrame({"noise": [0, 0.1, 0.4]}), "cross")
    evaluations = evaluations.merge(pd.DataFrame({"start": [0, 1]}), "cross")
    evaluations["speed"] = 0.006 * rng.random(len(evaluations))
    cycles = runs[runs["agent"].str.contains("a")].merge(pd.DataFrame({"start": [0, 1]}), "cross")
    cycles["duration"] = 40 + rng.random(len(cycles))
    tables = runs.merge(pd.DataFrame({"observation": range(n)}), "cross").drop(columns="speed")
    tables[[f"p_{action}" for action in range(n)]] = rng.dirichlet(np.ones(n), len(tables))
    plain = runs.drop_duplicates(["agent", "regularization", "seed"]).drop(columns="mode")
    curves = plain.merge(pd.DataFrame({"decisions": [1000.0, 2000.0, 3000.0]}), "cross")
    curves["speed"] = 0.006 * rng.random(len(curves))
    softened = plain.merge(pd.DataFrame({"temperature": [0, 0.25, 0.5, 1, 2, 4, np.inf]}), "cross")
    softened["speed"] = 0.006 * rng.random(len(softened))
    stuck = plain.assign(stuck=rng.integers(0, 6, len(plain)))
    return runs, evaluations, cycles, tables, curves, softened, stuck


def record(n=10, samples=1000):
    time = 0.2 * np.arange(samples)
    displacement = 0.005 * time[:, None] + 0.15 * np.sin(0.15 * time[:, None] + np.arange(n + 1))
    zero = np.zeros_like(displacement)
    return Record(time, displacement, zero, zero, zero, np.zeros(samples - 1, dtype=np.int64))


def all_figures(n=10, **case):
    runs, evaluations, cycles, tables, curves, softened, stuck = benchmark(n=n, **case)
    return {
        "speeds": speeds(runs),
        "cycles": cycle_durations(cycles, runs),
        "noise": noise_curves(evaluations),
        "learning": learning_curves(curves, runs),
        "policies": policy_matrices(tables, runs),
        "gaits": gaits({agent: record(n) for agent in runs["agent"].unique()}),
        "softening": softening(softened, stuck),
        "traps": trap_matrix(np.eye(n)),
    }


def texts(figure: Figure):
    return [text.get_text() for text in figure.findobj(matplotlib.text.Text)]


def lines(axes, label):
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_every_figure_is_drawn(case):
    for name, figure in all_figures(**case).items():
        figure.draw_without_rendering()
        assert figure.get_suptitle(), name
        assert any(axes.get_xlabel() for axes in figure.axes), name


def test_quantities_have_units():
    for name, figure in all_figures().items():
        said = " ".join(texts(figure))
        assert r"\tau_\theta" in said or name == "traps", name


def test_every_run_is_a_dot():
    runs = benchmark()[0]
    panels = speeds(runs).axes
    for axes, epsilon in zip(panels, (0, 0.01), strict=True):
        dots = [
            line.get_xdata()
            for line in axes.lines
            if line.get_linestyle() == "None" and len(line.get_xdata()) == 4
        ]
        given = runs[runs["regularization"] == epsilon]["speed"].to_numpy() * 1000
        np.testing.assert_allclose(np.sort(np.concatenate(dots)), np.sort(given))


def test_random_and_wave_are_lines_only_where_they_are():
    runs = benchmark()[0]
    assert "random (IQM)" in " ".join(text.get_text() for text in speeds(runs).legends[0].get_texts())
    axes = speeds(runs).axes[0]
    random = runs[(runs["agent"] == "random") & (runs["regularization"] == 0)]["speed"].sort_values()
    np.testing.assert_allclose(lines(axes, "random")[0], random.iloc[1:3].mean() * 1000)
    without = speeds(runs[runs["agent"] == "ppo"])
    assert "IQM" not in " ".join(text.get_text() for text in without.legends[0].get_texts())


def test_agents_without_a_cycle_are_said_to_have_no_wave():
    runs, _, cycles, *_ = benchmark()
    said = texts(cycle_durations(cycles, runs))
    assert said.count("no wave") == 4  # ppo in two modes and two regularizations
    assert said.count("4/4") == 4
    assert texts(cycle_durations(cycles.iloc[:0], runs)).count("no wave") == 8


def test_mean_duration_of_a_run_is_a_dot():
    runs, _, cycles, *_ = benchmark(pairs=[("wave", "deterministic")], regularizations=[0.0])
    axes = cycle_durations(cycles, runs).axes[0]
    np.testing.assert_allclose(axes.lines[0].get_xdata(), cycles.groupby("seed")["duration"].mean())


def test_noise_curves_are_means_over_runs_of_means_over_starts():
    evaluations = benchmark()[1]
    figure = noise_curves(evaluations)
    titles = [axes.get_title("left").replace("\n", " ") for axes in figure.axes]
    assert titles == [f"{agent}, {mode}" for agent, mode in USUAL]
    noise, speed = lines(figure.axes[1], "regularized (ε = 0.01)")
    chosen = select(evaluations, agent="ppo", mode="stochastic", regularization=0.01)
    given = chosen.groupby("noise")["speed"].mean()
    np.testing.assert_array_equal(noise, given.index)
    np.testing.assert_allclose(speed, given * 1000)


def test_the_crossover_is_marked_where_the_curves_cross():
    evaluations = benchmark(pairs=[("any", "deterministic")])[1]
    falling = (evaluations["regularization"] == 0) * (0.002 - 0.02 * evaluations["noise"])
    evaluations["speed"] = 0.004 + falling
    (axes,) = noise_curves(evaluations).axes
    (crossing,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    np.testing.assert_allclose(crossing.get_xdata(), 0.1)
    evaluations["speed"] = 0.004
    (axes,) = noise_curves(evaluations).axes
    assert not [line for line in axes.lines if line.get_linestyle() == ":"]


def test_learning_curves_are_interquartile_means():
    curves = benchmark()[4]
    figure = learning_curves(curves)
    decisions, speed = lines(figure.axes[0], "ppo")
    chosen = select(curves, agent="ppo", regularization=0)
    middle = chosen.groupby("decisions")["speed"].apply(lambda speeds: speeds.sort_values().iloc[1:3].mean())
    np.testing.assert_array_equal(decisions, [1000, 2000, 3000])
    np.testing.assert_allclose(speed, middle * 1000)


def test_no_agent_that_learned_is_said_so():
    figure = learning_curves(pd.DataFrame())
    assert "no agent learned" in texts(figure)
    figure.draw_without_rendering()


def test_policies_are_means_over_runs():
    runs, _, _, tables, *_ = benchmark()
    figure = policy_matrices(tables, runs)
    panels = [axes for axes in figure.axes if axes.get_title("left")]
    assert len(panels) == 8
    chosen = select(tables, agent="ppo", mode="stochastic", regularization=0.01)
    mean = chosen.groupby("observation")[[f"p_{action}" for action in range(10)]].mean().to_numpy()
    np.testing.assert_allclose(panels[3].images[0].get_array(), mean)
    title = panels[3].get_title("left")
    assert title.startswith("ppo\nstochastic, ε = 0.01, n = 4")
    assert f"off the diagonal {1 - np.diag(mean).mean():.2f}" in title


def test_gaits_share_colours_and_time():
    figure = gaits({"long": record(), "short": record(samples=100)})
    panels = [axes for axes in figure.axes if axes.get_title("left")]
    first, second = (axes.images[0] for axes in panels)
    assert first.norm.vmax == second.norm.vmax
    assert panels[0].get_xlim() == panels[1].get_xlim()
    assert panels[0].get_xlim()[1] == pytest.approx(120)
    np.testing.assert_allclose(second.get_array(), record(samples=100).strain.T)


def test_no_gait_is_said_so():
    assert "no gait" in texts(gaits({}))


def test_softened_speeds_stand_at_their_temperatures():
    *_, softened, stuck = benchmark()
    figure = softening(softened, stuck)
    places, speed = lines(figure.axes[0], "ppo")
    chosen = select(softened, agent="ppo", regularization=0)
    middle = chosen.groupby("temperature")["speed"].apply(lambda each: each.sort_values().iloc[1:3].mean())
    np.testing.assert_allclose(places, [-3.5, -2, -1, 0, 1, 2, 3.5])
    np.testing.assert_allclose(speed, middle * 1000)


def test_fixed_points_of_every_run_are_drawn():
    *_, softened, stuck = benchmark(seeds=2)
    figure = softening(softened.iloc[:0], stuck)
    figure.draw_without_rendering()
    dots = [line.get_xdata() for line in figure.axes[2].lines if line.get_marker() == "o"]
    given = stuck[stuck["regularization"] == 0]["stuck"]
    np.testing.assert_allclose(np.sort(np.concatenate(dots)), np.sort(given))


def test_softening_without_traps_counted():
    *_, softened, stuck = benchmark(seeds=1)
    softening(softened, stuck.iloc[:0]).draw_without_rendering()


def test_only_the_ends_of_all_temperatures():
    np.testing.assert_array_equal(temperature_places(np.array([0, np.inf])), [-1.5, 1.5])


def test_a_variant_looks_like_what_it_varies():
    found = of_agents(["dqn", "dqn-tuned", "other", "random", "random-slow", "dqn-tuned-more"])
    assert found["dqn"].colour == found["dqn-tuned"].colour == found["dqn-tuned-more"].colour
    assert len({found[name].dashes for name in ("dqn", "dqn-tuned", "dqn-tuned-more")}) == 3
    assert found["dqn"].colour != found["other"].colour
    assert found["random-slow"].colour == found["random"].colour


def test_many_agents_are_told_apart():
    assert len(set(of_agents(f"agent{i}" for i in range(11)).values())) == 11


def test_long_names_are_cut():
    assert truncate("ppo") == "ppo"
    assert truncate("a" * 30, 10) == "a" * 9 + "…"


def test_the_modes_of_an_agent_stay_in_one_row():
    assert places(["a", "a", "b", "c", "c"], 4) == [0, 1, 2, 4, 5]
    assert places(["a"] * 3, 2) == [0, 1, 2]  # more than a row holds
    figure = noise_curves(benchmark(pairs=[("x", "deterministic"), *USUAL[:2], ("y", "deterministic")])[1])
    titles = {axes.get_title("left").split(",")[0]: axes for axes in figure.axes if axes.get_title("left")}
    assert all(axes.get_xlabel() for name, axes in titles.items() if name == "y")


def test_every_panel_with_nothing_below_it_has_numbers_and_a_label():
    pairs = [(f"agent{i}", "deterministic") for i in range(6)]
    figure = noise_curves(benchmark(pairs=pairs, seeds=2)[1])
    figure.draw_without_rendering()
    panels = [axes for axes in figure.axes if axes.get_title("left")]
    labelled = [bool(axes.get_xlabel()) for axes in panels]
    assert labelled == [False, False, True, True, True, True]
    assert [axes.xaxis.get_tick_params()["labelbottom"] for axes in panels] == labelled
