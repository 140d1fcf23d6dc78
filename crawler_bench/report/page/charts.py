"""Curves that answer to the pointer: speed against noise, and speed while learning.

Plotly draws them: its script comes inside its Python package and needs no network, its marks are SVG, which a
style sheet can recolour for a dark page, and its legend shows and hides lines. Vega-Altair is smaller, but
it takes another 30 MB package to put it into a page, and each chart would have to program such a legend.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from markupsafe import Markup

from crawler_bench.benchmark.figures import looks
from crawler_bench.benchmark.keys import STOCHASTIC, select
from crawler_bench.output.cells import format_number
from crawler_bench.output.style import EXPERIMENT_COLOURS, SPEED_SCALE
from crawler_bench.statistics.estimates import Estimate, estimate

SPEED = "speed (10<sup>-3</sup> L/τ<sub>θ</sub>)"
NOISE = "largest error s of a sensed strain"
MOMENTS = 32  # of a learning curve that are shown, at most
_NOISE = "speed_noise_"
_DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}


@dataclass(frozen=True)
class Line:
    """One curve.

    Attributes:
        name: in the legend and beside the pointer.
        x: where.
        values: there, speeds in L/tau_theta.
        look: its colour and dashes.
        open: whether its dots are hollow.
    """

    name: str
    x: Sequence[float]
    values: Sequence[Estimate]
    look: looks.Look
    open: bool = False


@dataclass(frozen=True)
class Chart:
    """A chart, drawn.

    Attributes:
        title: what it shows.
        drawing: JSON for Plotly's script, without anything that could end a script element.
    """

    title: str
    drawing: Markup


def paper_noise(evaluations: pd.DataFrame) -> pd.DataFrame:
    """Mean speed of each experiment at each amplitude of noise, over runs, with its interval.

    Returns:
        experiment, noise, speed, low, high, n.
    """
    runs = evaluations.groupby(["experiment", "seed", "noise"], as_index=False)["speed"].mean()
    rows = []
    for name in (name for name in EXPERIMENT_COLOURS if name in set(runs["experiment"])):
        for noise, each in runs[runs["experiment"] == name].groupby("noise"):
            found = estimate(each["speed"].to_numpy(np.float64), statistic=np.mean)
            rows.append((name, noise, found.value, found.low, found.high, found.n))
    return pd.DataFrame(rows, columns=["experiment", "noise", "speed", "low", "high", "n"])


def paper_chart(speeds: pd.DataFrame) -> Chart:
    """Fig. 3C, of what `paper_noise` returns."""
    lines = []
    for name, rows in speeds.groupby("experiment", sort=False):
        look = looks.Look(EXPERIMENT_COLOURS[str(name)], "o", "--" if name == "untrained" else "-")
        shown = "random action" if name == "untrained" else str(name)
        lines.append(Line(shown, rows["noise"].tolist(), _estimates(rows, "speed"), look))
    return _draw("Speed against noise, mean over runs", NOISE, lines)


def noise_charts(summary: pd.DataFrame) -> list[Chart]:
    """Speed of every agent and mode against noise, a chart for each regularization."""
    rows = summary[summary["metric"].str.startswith(_NOISE)]
    rows = rows.assign(noise=rows["metric"].str.removeprefix(_NOISE).astype(float)).sort_values(
        "noise", kind="stable"
    )
    look_of, charts = looks.of_agents(summary["agent"]), []
    for value in looks.regularizations(summary):
        lines = []
        for agent, mode in looks.modes_of(summary):
            here = select(rows, agent=agent, mode=mode, regularization=value)
            if len(here):
                name, hollow = f"{agent}, {mode}", mode == STOCHASTIC
                lines.append(
                    Line(name, here["noise"].tolist(), _estimates(here, "value"), look_of[agent], hollow)
                )
        title = f"Speed against noise, {looks.regularization_label(value)}"
        charts.append(_draw(f"{title}: interquartile mean over runs", NOISE, lines))
    return charts


def learning_charts(curves: pd.DataFrame) -> list[Chart]:
    """Speed of every agent while it learns, a chart for each regularization."""
    if curves.empty:
        return []
    look_of, charts = looks.of_agents(curves["agent"]), []
    for value in looks.regularizations(curves):
        lines = []
        for agent, rows in select(curves, regularization=value).groupby("agent", sort=False):
            rows = rows.assign(window=rows.groupby("seed").cumcount())
            apart = -(-(int(rows["window"].max()) + 1) // MOMENTS)
            windows = rows[rows["window"] % apart == apart - 1].groupby("window")
            speeds = [estimate(each.to_numpy(np.float64)) for _, each in windows["speed"]]
            at = windows["decisions"].mean().tolist()
            lines.append(Line(str(agent), at, speeds, look_of[str(agent)]))
        title = f"Speed while learning, {looks.regularization_label(value)}"
        charts.append(_draw(f"{title}: interquartile mean over runs", "decisions", lines))
    return charts


def _estimates(rows: pd.DataFrame, column: str) -> list[Estimate]:
    return [Estimate(*each) for each in rows[[column, "low", "high", "n"]].itertuples(index=False)]


def _draw(title: str, x_title: str, lines: Iterable[Line]) -> Chart:
    figure = go.Figure()
    for line in lines:
        known = [(x, each) for x, each in zip(line.x, line.values, strict=True) if each.n]
        if known:
            _add(figure, line, *zip(*known, strict=True))
    axis = {"gridcolor": "#8884", "zerolinecolor": "#8888", "linecolor": "#8888", "automargin": True}
    figure.update_layout(
        margin={"l": 60, "r": 10, "t": 10, "b": 50}, hovermode="closest",
        paper_bgcolor="rgba(0,0,0,0)", plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 13},
        legend={"orientation": "h", "yref": "container", "y": 0, "yanchor": "bottom", "x": 0,
                "maxheight": 1, "itemsizing": "constant"},
        xaxis=axis | {"title": x_title}, yaxis=axis | {"title": SPEED, "rangemode": "tozero"},
    )  # fmt: skip
    drawing = figure.to_json().replace("<", "\\u003c")
    return Chart(title, Markup(drawing))


def _add(figure: go.Figure, line: Line, x: Sequence[float], values: Sequence[Estimate]) -> None:
    """A line with dots, and its band, which the legend shows and hides with it."""
    low, high, middle = (
        [getattr(each, end) * SPEED_SCALE for each in values] for end in ("low", "high", "value")
    )
    colour, name = line.look.colour, str(Markup.escape(line.name))
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    band = {
        "x": [*x, *reversed(x)], "y": [*high, *reversed(low)], "fill": "toself",
        "fillcolor": f"rgba({red},{green},{blue},0.15)", "line": {"width": 0}, "mode": "lines",
        "hoverinfo": "skip", "showlegend": False, "legendgroup": name,
    }  # fmt: skip
    figure.add_trace(go.Scatter(**band))
    said = [
        f"{format_number(v)} [{format_number(a)} .. {format_number(b)}], n = {each.n}"
        for v, a, b, each in zip(middle, low, high, values, strict=True)
    ]
    figure.add_trace(
        go.Scatter(
            x=x,
            y=middle,
            name=name,
            legendgroup=name,
            mode="lines+markers" if len(x) < 20 else "lines",
            line={"color": colour, "width": 2, "dash": _DASHES[line.look.dashes]},
            marker={"size": 6, "symbol": "circle-open" if line.open else "circle"},
            customdata=said,
            hovertemplate=f"<b>{name}</b><br>%{{x}}: %{{customdata}}<extra></extra>",
        )
    )
