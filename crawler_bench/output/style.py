"""The look of all figures: colours, panels, colour bars, and how a figure is saved."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.layout_engine import ConstrainedLayoutEngine

from crawler_bench.envs.palette import CONTRACTION_LIMIT, CONTRACTION_SCALE
from crawler_bench.statistics.estimates import Array, Estimate

RED, BLUE, GREY = "#c0392b", "#2166ac", "#7f7f7f"
GREEN, LIGHT_GREEN = "#00734d", "#a8dbc5"
ORANGE, INK = "#d95f02", "#333333"
EXPERIMENT_COLOURS = {"regularized": RED, "unregularized": BLUE, "untrained": GREY}

# Contraction in red, like the animated crawler; muscle forces in pink.
CONTRACTION = LinearSegmentedColormap.from_list("contraction", np.array(CONTRACTION_SCALE) / 255)
FORCE = LinearSegmentedColormap.from_list("force", ["#ffffff", "#fbc5dc", "#e7559c", "#a0056e", "#49006a"])
NODES = LinearSegmentedColormap.from_list("nodes", mpl.colormaps["viridis"](np.linspace(0, 0.92, 64)))
RANK = LinearSegmentedColormap.from_list("rank", ["#ffffff", "#c9c9c9", "#4d4d4d"])

TIME_LABEL = r"time ($\tau_\theta$)"
STRAIN_LABEL = "strain\n(contraction positive)"
SPEED_SCALE, SPEED_UNIT = 1e3, r"$10^{-3}\,L/\tau_\theta$"  # speeds are drawn in thousandths
SPEED_LABEL = f"speed ({SPEED_UNIT})"
FORCE_LABEL = r"muscle force ($k\,L$)"

PNG_DPI = 150
_SALT = "crawler-bench"  # of the identifiers inside an SVG: equal figures give equal bytes


def new_figure(width: float, height: float, title: str = "") -> Figure:
    """An empty figure of a size in inches, with constrained layout."""
    figure = Figure(
        figsize=(width, height), dpi=PNG_DPI, layout=ConstrainedLayoutEngine(h_pad=0.1, w_pad=0.12)
    )
    if title:
        figure.suptitle(title, fontsize=12, fontweight="bold", color=INK)
    return figure


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write name.png (150 dpi) and name.svg; equal figures give equal bytes.

    Args:
        figure: made by `new_figure`.
        folder: where; made if missing.
        name: of the files, without suffix.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _settle(figure)
    with mpl.rc_context({"svg.hashsalt": _SALT}):
        figure.savefig(folder / f"{name}.png", dpi=PNG_DPI)
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})


def _settle(figure: Figure) -> None:
    """Fix all panels where the layout put them, rounded: the last digits differ from run to run."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 5).tolist())


def heading(axes: Axes, title: str) -> None:
    """A title above a panel, flush left."""
    axes.set_title(title, loc="left", fontsize=10, color=INK)


def tidy(axes: Axes, title: str) -> None:
    """Remove the frame's upper and right side, and head the panel."""
    axes.spines[["top", "right"]].set_visible(False)
    heading(axes, title)


def show_missing(axes: Axes, text: str) -> None:
    """Write in the middle of a panel why it is empty."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=INK, style="italic")


def kymograph(
    axes: Axes,
    time: Array,
    values: Array,
    cmap: LinearSegmentedColormap,
    limits: tuple[float, float],
    first: int,
) -> AxesImage:
    """Values along the body (head on top) against time.

    Args:
        axes: where.
        time: (T,) evenly spaced, tau_theta.
        values: (T, P).
        cmap: colours.
        limits: values at the ends of the colours.
        first: number of the part of the body at the head: segments count from 1, muscles from 0.
    """
    parts = values.shape[1]
    step = (time[-1] - time[0]) / max(time.size - 1, 1) or 1.0
    extent = (time[0] - step / 2, time[-1] + step / 2, first + parts - 0.5, first - 0.5)
    image = axes.imshow(
        values.T, aspect="auto", cmap=cmap, norm=Normalize(*limits), extent=extent, interpolation="nearest"
    )
    axes.set_yticks(part_ticks(parts, first))
    return image


def strain_kymograph(axes: Axes, time: Array, strain: Array) -> AxesImage:
    """Strain (T, N) of every segment against time, in the colours of contraction."""
    image = kymograph(axes, time, strain, CONTRACTION, (-CONTRACTION_LIMIT, CONTRACTION_LIMIT), 1)
    axes.set_ylabel("segment (1: head)")
    return image


def force_kymograph(axes: Axes, time: Array, force: Array) -> AxesImage:
    """Force (T, N + 1) of every muscle against time, k L."""
    image = kymograph(axes, time, force, FORCE, (0.0, max(1.0, float(force.max()))), 0)
    axes.set_ylabel("muscle (0: head)")
    return image


def colour_bar(
    axes: Axes | Sequence[Axes], image: AxesImage, label: str, values: Array | None = None, **room: Any
) -> None:
    """A colour bar to the right of its panels, pointed where values lie beyond it.

    Args:
        axes: the panels that it explains.
        image: in one of them.
        label: of the bar.
        values: in all of them; by default the image's.
        room: another place or size, as `Figure.colorbar` takes it.
    """
    shown, norm = np.asarray(image.get_array() if values is None else values), image.norm
    below, above = bool(shown.min() < norm.vmin), bool(shown.max() > norm.vmax)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[below, above]
    figure = image.get_figure(root=True)
    assert figure is not None
    place = {"ax": axes, "pad": 0.015, "aspect": 12} | room
    bar = figure.colorbar(image, label=label, extend=extend, **place)
    bar.outline.set_visible(False)


def band(axes: Axes, x: Array, values: Sequence[Estimate], *, alpha: float = 0.18, **look: Any) -> None:
    """Draw a line of estimates with the band of their intervals."""
    low, high = ([getattr(each, end) for each in values] for end in ("low", "high"))
    axes.fill_between(x, low, high, color=look["color"], alpha=alpha, lw=0)
    axes.plot(x, [each.value for each in values], **look)


def mark_middle(axes: Axes, middle: Estimate, row: float, **look: Any) -> None:
    """The middle of runs as a bar in a row, with its interval."""
    if middle.n:
        ends = ([middle.value - middle.low], [middle.high - middle.value])
        usual: dict[str, Any] = {"color": INK, "marker": "|", "capsize": 3, "lw": 1.2, "zorder": 3}
        axes.errorbar(middle.value, row, xerr=ends, **usual | look)


def grouped(number: float) -> str:
    """A whole number with thin spaces between its thousands."""
    return f"{number:,.0f}".replace(",", "\u2009")


def square(axes: Axes, n: int) -> None:
    """Limits and ticks of a policy: one row per segment, from 1, one column per neuron, from 0.

    So segments, and muscles with their neurons, have the same numbers in every figure; on the diagonal a
    segment switches on the neuron of its neighbour ahead.
    """
    rows = part_ticks(n)
    axes.set(xticks=part_ticks(n), yticks=rows, xlim=(-0.5, n - 0.5), ylim=(n - 0.5, -0.5))
    axes.set_yticklabels([str(row + 1) for row in rows])


def part_ticks(parts: int, first: int = 0) -> list[int]:
    """Numbers of the parts of a body to write at an axis: all, or about ten of many."""
    return list(range(first, first + parts, max(1, -(-parts // 11))))
