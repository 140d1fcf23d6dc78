"""The figures of the readings: profiles of the score, distances, what the conclusion depends on."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from crawler_bench.output.style import BLUE, GREEN, GREY, INK, ORANGE, RED, new_figure, tidy
from crawler_bench.readings.catalogue import DEFAULT
from crawler_bench.readings.fields import FIELDS, GIVEN, Field
from crawler_bench.readings.identifiability import ends, group_distances, profile, value_word
from crawler_bench.readings.laboratory import Scored
from crawler_bench.readings.scoring import CAP, CORE, TOLERANCE, group_of

UNITS = {
    "tau_f": r"$\tau_f$ ($\tau_\theta$)",
    "tau_m": r"$\tau_m$ ($\tau_\theta$)",
    "neuron_rate": r"neuron_rate ($1/\tau_\theta$)",
    "spike_gain": "spike_gain",
    "decision_interval": r"decision_interval ($\tau_\theta$)",
    "dt": r"dt of implicit Euler steps ($\tau_\theta$)",
    "initial_q": "initial_q ($L$)",
    "episode_distance": "episode_distance ($L$)",
    "time_limit": r"time_limit ($\tau_\theta$)",
    "learning_rate": r"$\alpha$",
    "discount": r"$\gamma$",
    "n_segments": "segments $N$",
    "regularization": r"$\epsilon$",
}
TOP = 10  # readings of the ranking in the map of distances


def all_figures(scored: Sequence[Scored]) -> dict[str, Figure]:
    """All figures by file name."""
    return {
        "profiles": profiles(scored),
        "distances": distances(scored),
        "conclusion": conclusion(ends(scored)),
        "strength": strength(scored),
    }


def profiles(scored: Sequence[Scored]) -> Figure:
    """The score along each field, varied alone."""
    numeric = [field for field in FIELDS if field.name in UNITS]
    figure = new_figure(10.5, 10.5, "What each choice does to the score (all others as in the default)")
    panels = figure.subplots(4, 3, sharey=True)
    for axes, field in zip(panels.flat, numeric, strict=False):
        _draw_profile(axes, field, profile(field, scored))
    _draw_choices(panels.flat[len(numeric)], scored)
    for axes in panels.flat[len(numeric) + 1 :]:
        axes.set_axis_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("score (0: the paper's story)")
    panels[0, 0].set_ylim(0, CAP)
    _explain(panels.flat[len(numeric) + 1])
    return figure


def _explain(axes: Axes) -> None:
    """The legend of the profiles, in a panel of its own."""
    handles = [
        Line2D([], [], color=BLUE, marker="o", label="within tolerance, with 95 % interval"),
        Line2D([], [], color=BLUE, marker="o", mfc="white", label="a core claim fails, or score above 1"),
        Line2D([], [], color=ORANGE, marker="s", ms=11, mfc="none", ls="", label="value with a source"),
        Line2D([], [], color=GREY, ls=":", label="the default"),
        Line2D([], [], color=GREEN, ls="--", label="tolerance of the score"),
    ]
    axes.legend(handles=handles, loc="center left", frameon=False, fontsize=9)


def _draw_profile(axes: Axes, field: Field, along: Sequence[Scored]) -> None:
    """Values in their order, one after another: they crowd on any scale."""
    place = range(len(along))
    axes.plot(place, [each.score.value for each in along], color=BLUE, lw=1)
    for at, each in zip(place, along, strict=True):
        exact = field.name == "dt" and each.values["parameters.integrator"] == "exact"
        _draw_point(axes, at, each, sourced=not exact and field.is_sourced(each.values[field.key]))
        if each.reading.name == DEFAULT.name:
            axes.axvline(at, color=GREY, ls=":", lw=1)
    axes.axhline(TOLERANCE, color=GREEN, ls="--", lw=1)
    axes.set_xticks(place, [value_word(field, each) for each in along], fontsize=8)
    axes.set_xlim(-0.5, len(along) - 0.5)
    axes.set_xlabel(UNITS[field.name])
    axes.spines[["top", "right"]].set_visible(False)


def _draw_point(axes: Axes, x: float, each: Scored, *, sourced: bool) -> None:
    low, high = each.score.interval
    axes.plot([x, x], [low, high], color=BLUE, lw=1.2)
    axes.plot(
        x, each.score.value, marker="o", color=BLUE, mfc=BLUE if each.score.within else "white", zorder=3
    )
    if sourced:
        axes.plot(x, each.score.value, marker="s", ms=11, mfc="none", color=ORANGE, mew=1.4)


def _draw_choices(axes: Axes, scored: Sequence[Scored]) -> None:
    """Readings of words: one column each."""
    fields = [field for field in FIELDS if field.name not in UNITS]
    chosen = [
        each for field in fields for each in profile(field, scored) if each.reading.name != DEFAULT.name
    ]
    for x, each in enumerate(chosen):
        _draw_point(axes, x, each, sourced=True)
    names = [each.reading.name.replace("=", "\n= ") for each in chosen]
    axes.set_xticks(range(len(chosen)), names, fontsize=7, rotation=40, ha="right")
    axes.axhline(TOLERANCE, color=GREEN, ls="--", lw=1)
    axes.set_xlim(-0.5, max(len(chosen), 1) - 0.5)
    axes.spines[["top", "right"]].set_visible(False)


def distances(scored: Sequence[Scored]) -> Figure:
    """What each reading gets wrong: distance of every group, for the head of the ranking and the named."""
    open_ones = [each for each in scored if each.reading.family != "given"]
    families = ("default", "literal", "repairs", "sourced")
    chosen = [each for i, each in enumerate(open_ones) if i < TOP or each.reading.family in families]
    table = pd.DataFrame([group_distances(each.score) for each in chosen])
    ranks = {each.reading.name: number for number, each in enumerate(scored, 1)}
    figure = new_figure(11, 0.3 * len(chosen) + 3.2, "What each reading gets wrong")
    axes = figure.add_subplot()
    colours = ListedColormap(["#ffffff", "#d1e5f0", "#92c5de", "#4393c3", "#2166ac", "#053061"])
    edges = np.array([0, 0.5, 1, 2, 3, 4, 5])
    shades = np.digitize(table.to_numpy(), edges[1:-1], right=True)
    image = axes.imshow(shades, cmap=colours, vmin=-0.5, vmax=5.5, aspect="auto")
    core = {group_of(name) for name in CORE}
    axes.set_xticks(range(table.shape[1]), [f"{name} *" if name in core else name for name in table.columns],
                    rotation=45, ha="right", fontsize=9)  # fmt: skip
    labels = [
        f"{each.reading.name}  ({ranks[each.reading.name]}; {each.score.value:.2f}; {len(each.free)} free)"
        for each in chosen
    ]
    axes.set_yticks(range(len(chosen)), labels, fontsize=8)
    for tick, each in zip(axes.get_yticklabels(), chosen, strict=True):
        if each.reading.family in ("default", "literal"):
            tick.set_fontweight("bold")
    axes.set_xticks(np.arange(-0.5, table.shape[1]), minor=True)
    axes.set_yticks(np.arange(-0.5, len(chosen)), minor=True)
    axes.grid(which="minor", color="#dddddd", lw=0.5)
    axes.tick_params(which="minor", length=0)
    axes.set_xlabel("group of claims (* holds a core claim)")
    axes.set_ylabel("reading (rank; score; free constants)")
    bar = figure.colorbar(image, ax=axes, pad=0.01, label="distance to the paper (tolerances)")
    bar.set_ticks(list(range(6)), labels=["0 - 0.5", "0.5 - 1", "1 - 2", "2 - 3", "3 - 4", "4 - 5"])
    return figure


LOOKS = {
    "ends on the diagonal": (RED, "o"),
    "wave from tail to head": (BLUE, "s"),
    "localized wave": (GREEN, "^"),
}  # fmt: skip


def conclusion(shares: pd.DataFrame) -> Figure:
    """Share of regularized runs that end as the paper says, against what the paper does give.

    Args:
        shares: what `crawler_bench.readings.identifiability.ends` returns.
    """
    figure = new_figure(10.5, 6.8, "Does the paper's conclusion depend on what it gives?")
    panels = figure.subplots(2, 2, sharey=True)
    for axes, field in zip(panels.flat, (GIVEN[3], *GIVEN[:3]), strict=True):
        _draw_shares(axes, field, shares[shares["field"] == field.name])
    for axes in panels[:, 0]:
        axes.set_ylabel("share of training runs")
    panels[0, 0].set_ylim(-0.03, 1.03)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _draw_shares(axes: Axes, field: Field, shares: pd.DataFrame) -> None:
    values = np.sort(shares["value"].unique())
    place = np.arange(values.size)  # one after another: the values are chosen to be of equal interest
    for shift, (end, (colour, marker)) in zip((-0.08, 0.0, 0.08), LOOKS.items(), strict=True):
        row = shares[shares["end"] == end].set_index("value").loc[values]
        bars = np.clip([row["share"] - row["low"], row["high"] - row["share"]], 0, None)
        axes.errorbar(place + shift, row["share"], yerr=bars, color=colour, marker=marker, capsize=2, lw=1.2,
                      label=end)  # fmt: skip
    axes.set_xticks(place, [f"{value:g}" for value in values], fontsize=9)
    papers = [i for i, value in enumerate(values) if field.is_sourced(float(value))]
    for at in papers:
        axes.axvline(float(place[at]), color=GREY, ls=":", lw=1, label="the paper's value")
    axes.set_xlabel(UNITS[field.name])
    axes.spines[["top", "right"]].set_visible(False)


def strength(scored: Sequence[Scored]) -> Figure:
    """Score of every reading of two numbers that only their product fixes: neuron_rate and spike_gain."""
    figure = new_figure(7.5, 5.6, "How the strength of a muscle is split")
    axes = figure.add_subplot()
    tidy(axes, "Every reading by the two factors; dashed: the same product")
    shown = [
        each for each in scored if each.reading.family in ("default", "alone", "pairs", "sparse", "search")
    ]
    rate, gain = (
        np.array([float(str(each.values[f"parameters.{name}"])) for each in shown])
        for name in ("neuron_rate", "spike_gain")
    )
    values = np.array([each.score.value for each in shown])
    order = np.argsort(-values, kind="stable")
    within = np.array([each.score.within for each in shown])[order]
    edges = [RED if each else "none" for each in within]
    points = axes.scatter(
        rate[order], gain[order], c=values[order], edgecolors=edges, cmap="viridis_r", vmin=0, vmax=3, s=46,
        linewidths=1.4,
    )  # fmt: skip
    grid = np.geomspace(0.8, 7, 60)
    for product in (2, 4, 6):
        axes.plot(grid, product / grid, color=GREY, lw=0.8, ls="--")
        axes.annotate(f"{product}", (1.02, product * 1.02), color=INK, fontsize=8)
    axes.set(xscale="log", yscale="log", xlim=(0.85, 6.8), ylim=(0.75, 6.8))
    ticks = [1, 1.5, 2, 3, 4, 6]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.set_xlabel(UNITS["neuron_rate"])
    axes.set_ylabel(UNITS["spike_gain"])
    figure.colorbar(points, ax=axes, label="score (0: the paper's story)", extend="max")
    axes.plot([], [], ls="", marker="o", mfc="none", mec=RED, label="within tolerance")
    axes.legend(loc="upper right", frameon=False, fontsize=9)
    return figure
