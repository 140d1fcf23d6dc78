"""All figures and films, drawn from made-up records and tables."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from crawler_bench.output.kymographs import gait
from crawler_bench.paper.figure_1 import fig_1a
from crawler_bench.paper.figure_2 import learning, policies
from crawler_bench.paper.figure_3 import cycle_durations, power_by_phase, speed_against_noise
from crawler_bench.paper.figure_s1 import untrained
from tests.output.samples import texts, travelling_wave

NAMES = ("regularized", "unregularized")


def learning_inputs(n=10, moments=30):
    rng = np.random.default_rng(0)
    decisions = np.arange(moments) * 10_000
    tables = rng.normal(size=(moments, n, n))
    tables[0] = 0.2
    rows = [
        (name, seed, t, max(0, n - k)) for name in NAMES for seed in range(3) for k, t in enumerate(decisions)
    ]
    columns = ["experiment", "seed", "decisions", "diagonal_distance"]
    return {name: (decisions, tables) for name in NAMES}, pd.DataFrame(rows, columns=columns)


def cycle_table():
    rng = np.random.default_rng(1)
    rows = [
        (name, seed, start, mean + rng.normal())
        for name, mean in zip(NAMES, (40, 26), strict=True)
        for seed in range(4)
        for start in range(3)
    ]
    return pd.DataFrame(rows, columns=["experiment", "seed", "start", "duration"])


def noise_table(names=(*NAMES, "untrained"), seeds=4):
    rng = np.random.default_rng(2)
    rows = [
        (name, seed, noise, start, 0.005 + 0.001 * rng.random(), False)
        for name in names
        for seed in range(seeds)
        for noise in (0.0, 0.1, 0.2)
        for start in range(2)
    ]
    return pd.DataFrame(rows, columns=["experiment", "seed", "noise", "start", "speed", "stalled"])


def phased(cycles, n=10):
    values = np.random.default_rng(3).random((cycles, 50, n + 1))
    values[:1, 7] = np.nan
    if cycles:
        values[:, 9] = np.nan
    return values


@cache
def all_figures(n=10):
    record = travelling_wave(n)
    return {
        "fig_1a": fig_1a(),
        "gait": gait(record, "A gait"),
        "policies": policies(
            {"regularized": np.eye(n), "unregularized": np.full((n, n), 1 / n)},
            {"regularized": range(n), "unregularized": [0]},
        ),
        "power": power_by_phase({"regularized": phased(3, n), "unregularized": phased(1, n)}),
        "durations": cycle_durations(cycle_table()),
        "noise": speed_against_noise(noise_table(), (0.1, 0.05, 0.15)),
        "untrained": untrained(record),
        "learning": learning(*learning_inputs(n)),
    }


@pytest.mark.parametrize("n", [2, 10])
def test_every_figure_is_drawn(n):
    for figure in all_figures(n).values():
        figure.draw_without_rendering()


def test_axes_say_what_they_show():
    for name, figure in all_figures().items():
        if name == "fig_1a":
            continue
        assert figure.get_suptitle(), name
        assert any(axes.get_xlabel() for axes in figure.axes), name
        for axes in figure.axes:
            labelled = axes.get_ylabel() or axes.get_xlabel() or axes.get_title("left")
            assert labelled, name


def test_quantities_have_units():
    for name in ("gait", "untrained"):
        said = texts(all_figures()[name])
        assert r"time ($\tau_\theta$)" in said
        assert "($k\\,L$)" in said
        assert "contraction positive" in said


def test_no_cycles_are_said_so():
    durations = cycle_durations(cycle_table().iloc[:0])
    power = power_by_phase({"regularized": phased(2), "unregularized": phased(0)})
    for figure in (durations, power):
        assert "no cycle found" in texts(figure)
        figure.draw_without_rendering()


def test_no_power_of_any_gait():
    power_by_phase({name: phased(0) for name in NAMES}).draw_without_rendering()


def test_equal_cycles_of_one_run():
    cycles = pd.DataFrame({"experiment": "regularized", "seed": 0, "start": 0, "duration": [40.0, 40.0]})
    cycle_durations(cycles).draw_without_rendering()


def test_no_crossover_of_single_runs():
    figure = speed_against_noise(noise_table(NAMES, seeds=1), (np.nan, np.nan, np.nan))
    assert "faster from" not in texts(figure)
    assert "(1 run)" in texts(figure)
    figure.draw_without_rendering()


def test_crossover_without_interval():
    figure = speed_against_noise(noise_table(), (0.1, np.nan, np.nan))
    assert "faster from 0.100 on" in texts(figure)
    assert "interval of this crossover" not in texts(figure)


def test_mean_speed_is_over_runs_not_over_starts():
    table = noise_table(["regularized"], seeds=2)
    table["speed"] = np.where(table["seed"] == 0, 0.004, 0.008)
    extra = table[(table["seed"] == 0)].assign(start=7)
    figure = speed_against_noise(pd.concat([table, extra]), (np.nan,) * 3)
    mean = next(line for line in figure.axes[0].lines if line.get_label().startswith("regularized"))
    np.testing.assert_allclose(mean.get_ydata(), 6.0)


def test_greedy_actions_are_marked_where_there_is_one_best():
    snapshots, distances = learning_inputs()
    figure = learning({"regularized": snapshots["regularized"]}, distances)
    matrices = [axes for axes in figure.axes if axes.images]
    start, *_, end = [np.asarray(axes.lines[0].get_xdata()) for axes in matrices]
    assert start.size == 0
    np.testing.assert_array_equal(end, snapshots["regularized"][1][-1].argmax(axis=1))


def test_power_is_drawn_beyond_the_cycle_so_that_no_peak_is_cut():
    cycles = phased(3)
    figure = power_by_phase({"regularized": cycles})
    axes = figure.axes[0]
    assert axes.get_xlim()[0] < 0 < 1 < axes.get_xlim()[1]
    thin, mean = axes.lines[1], axes.lines[3]  # of node 0: the second cycle, and the mean after all three
    count = cycles.shape[1]
    beyond = (len(thin.get_ydata()) - count) // 2
    assert beyond > 0
    np.testing.assert_allclose(thin.get_ydata()[:beyond], cycles[0, -beyond:, 0])
    np.testing.assert_allclose(thin.get_ydata()[-beyond:], cycles[2, :beyond, 0])
    np.testing.assert_allclose(mean.get_ydata()[:beyond], mean.get_ydata()[count : count + beyond])


def test_rare_long_cycles_are_in_an_inset_and_do_not_squeeze_the_others():
    rng = np.random.default_rng(0)
    frame = pd.DataFrame({"experiment": "regularized", "seed": np.arange(1000) % 5, "start": 0})
    frame["duration"] = 40 + rng.random(1000)
    ordinary = cycle_durations(frame).axes[0]
    assert not ordinary.child_axes
    frame.loc[0, "duration"] = 95.0
    histogram = cycle_durations(frame).axes[0]
    assert histogram.get_xlim()[1] < 60
    assert histogram.child_axes[0].get_xlim()[1] > 94


def test_policies_count_segments_from_one_and_neurons_from_zero():
    figure = policies({"regularized": np.eye(10)}, {"regularized": range(10)})
    axes = figure.axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == [str(i) for i in range(1, 11)]
    assert list(axes.get_xticks()) == list(range(10))
