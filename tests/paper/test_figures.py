"""All figures and films, drawn from made-up records and tables."""

from functools import cache

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image

from crawler_bench.envs.rendering import contraction_colour
from crawler_bench.gait.record import Record
from crawler_bench.output.animation import GIF, animate
from crawler_bench.output.style import BLUE, CONTRACTION, RED
from crawler_bench.paper import figures

NAMES = ("regularized", "unregularized")


def travelling_wave(n=10, duration=130.0, interval=0.2):
    """A contraction that moves from tail to head once in 40 tau while the body drifts forward."""
    time = np.arange(round(duration / interval) + 1) * interval
    node = np.arange(n + 1)
    phase = 2 * np.pi * (time[:, None] / 40 + node / (n + 1))
    displacement = 0.005 * time[:, None] + 0.15 * np.sin(phase)
    force = np.clip(np.sin(phase), 0, 1)
    velocity = np.gradient(displacement, time, axis=0)
    return Record(
        time, displacement, velocity, force, np.abs(force * velocity), np.zeros(time.size - 1, dtype=np.int64)
    )


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
        "fig_1a": figures.fig_1a(),
        "gait": figures.gait(record, "A gait"),
        "policies": figures.policies(
            {"regularized": np.eye(n), "unregularized": np.full((n, n), 1 / n)},
            {"regularized": range(n), "unregularized": [0]},
        ),
        "power": figures.power_by_phase({"regularized": phased(3, n), "unregularized": phased(1, n)}),
        "durations": figures.cycle_durations(cycle_table()),
        "noise": figures.speed_against_noise(noise_table(), (0.1, 0.05, 0.15)),
        "untrained": figures.untrained(record),
        "learning": figures.learning(*learning_inputs(n)),
    }


def texts(figure: Figure):
    return " ".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))


@pytest.mark.parametrize("n", [2, 10])
def test_every_figure_is_drawn(n):
    for figure in all_figures(n).values():
        figure.draw_without_rendering()


def test_a_figure_is_written_into_a_new_folder(tmp_path):
    figures.save(all_figures()["policies"], tmp_path / "new", "policies")
    with Image.open(tmp_path / "new" / "policies.png") as picture:
        assert min(picture.size) > 500
    assert (tmp_path / "new" / "policies.svg").read_text().startswith("<?xml")


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


@pytest.mark.parametrize(
    "draw",
    [
        lambda: figures.gait(travelling_wave(duration=4), "short"),
        lambda: figures.cycle_durations(cycle_table()),
    ],
)
def test_the_same_figure_gives_the_same_bytes(draw, tmp_path):
    for folder in ("one", "two"):
        figures.save(draw(), tmp_path / folder, "figure")
    for suffix in ("svg", "png"):
        one, two = ((tmp_path / folder / f"figure.{suffix}").read_bytes() for folder in ("one", "two"))
        assert one == two


def test_no_cycles_are_said_so():
    durations = figures.cycle_durations(cycle_table().iloc[:0])
    power = figures.power_by_phase({"regularized": phased(2), "unregularized": phased(0)})
    for figure in (durations, power):
        assert "no cycle found" in texts(figure)
        figure.draw_without_rendering()


def test_no_power_of_any_gait():
    figures.power_by_phase({name: phased(0) for name in NAMES}).draw_without_rendering()


def test_equal_cycles_of_one_run():
    cycles = pd.DataFrame({"experiment": "regularized", "seed": 0, "start": 0, "duration": [40.0, 40.0]})
    figures.cycle_durations(cycles).draw_without_rendering()


def test_no_crossover_of_single_runs():
    figure = figures.speed_against_noise(noise_table(NAMES, seeds=1), (np.nan, np.nan, np.nan))
    assert "faster from" not in texts(figure)
    assert "(1 run)" in texts(figure)
    figure.draw_without_rendering()


def test_crossover_without_interval():
    figure = figures.speed_against_noise(noise_table(), (0.1, np.nan, np.nan))
    assert "faster from 0.100 on" in texts(figure)
    assert "interval of this crossover" not in texts(figure)


def test_mean_speed_is_over_runs_not_over_starts():
    table = noise_table(["regularized"], seeds=2)
    table["speed"] = np.where(table["seed"] == 0, 0.004, 0.008)
    extra = table[(table["seed"] == 0)].assign(start=7)
    figure = figures.speed_against_noise(pd.concat([table, extra]), (np.nan,) * 3)
    mean = next(line for line in figure.axes[0].lines if line.get_label().startswith("regularized"))
    np.testing.assert_allclose(mean.get_ydata(), 6.0)


def test_gait_shows_its_first_120_time_units():
    late = travelling_wave(duration=300).after(100)
    axes = figures.gait(late, "A gait").axes[2]
    low, high = axes.get_xlim()
    assert low == pytest.approx(0, abs=0.2)
    assert high == pytest.approx(120, abs=0.2)


def test_greedy_actions_are_marked_where_there_is_one_best():
    snapshots, distances = learning_inputs()
    figure = figures.learning({"regularized": snapshots["regularized"]}, distances)
    matrices = [axes for axes in figure.axes if axes.images]
    start, *_, end = [np.asarray(axes.lines[0].get_xdata()) for axes in matrices]
    assert start.size == 0
    np.testing.assert_array_equal(end, snapshots["regularized"][1][-1].argmax(axis=1))


def test_figures_and_films_colour_contraction_alike():
    for strain in (-0.4, -0.17, 0.0, 0.3, 0.4):
        of_figures = np.array(CONTRACTION((strain + 0.4) / 0.8))[:3] * 255
        np.testing.assert_allclose(of_figures, contraction_colour(strain), atol=4)
    assert RED != BLUE


@pytest.mark.parametrize(("n", "duration"), [(2, 2), (10, 3)])
def test_gif(n, duration, tmp_path):
    for name in ("one.gif", "two.gif"):
        animate(travelling_wave(n, duration), tmp_path / "films" / name, "A gait")
    with Image.open(tmp_path / "films" / "one.gif") as film:
        assert film.n_frames == pytest.approx(duration / 5 * GIF.fps, abs=1)
        assert film.size == (GIF.width, GIF.body_height + GIF.panel_height)
        first = np.asarray(film.convert("RGB"))
        film.seek(film.n_frames - 1)
        assert (first != np.asarray(film.convert("RGB"))).any()
    assert (tmp_path / "films" / "one.gif").read_bytes() == (tmp_path / "films" / "two.gif").read_bytes()


def test_mp4(tmp_path):
    for name in ("one.mp4", "two.mp4"):
        animate(travelling_wave(duration=1), tmp_path / name, "A gait")
    written = (tmp_path / "one.mp4").read_bytes()
    assert len(written) > 1000
    assert written == (tmp_path / "two.mp4").read_bytes()


def test_a_film_is_a_gif_or_an_mp4(tmp_path):
    with pytest.raises(ValueError, match=r"\.gif or an \.mp4"):
        animate(travelling_wave(duration=2), tmp_path / "film.avi", "A gait")
