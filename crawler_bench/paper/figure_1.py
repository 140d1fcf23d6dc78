"""Fig. 1A, the model: the parts of a segment, and the friction of the ground."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse, FancyArrowPatch, Rectangle

from crawler_bench.output.style import GREY, INK, new_figure

MUSCLE, NEURON, GROUND = "#e7559c", "#f0b429", "#c9b99a"
SPRING_HEIGHT, DAMPER_HEIGHT, MUSCLE_HEIGHT, NEURON_HEIGHT = 0.28, -0.28, 0.95, 2.0
_NODE_NAMES = ("N", "N \N{MINUS SIGN} 1", "2", "1", "0")  # from the tail, on the left, to the head
_NODES = (0.0, 2.6, 5.4, 8.0, 10.6)  # where they are drawn; between N - 1 and 2 the body goes on
_PARTS = {
    "spring $k$": SPRING_HEIGHT,
    "damper $c$": DAMPER_HEIGHT,
    "muscle": MUSCLE_HEIGHT,
    "neuron": NEURON_HEIGHT,
}
Point = tuple[float, float]
_GAP = 1  # index of the segment in whose place an ellipsis is drawn


def fig_1a() -> Figure:
    """Fig. 1A: the crawler as springs, dampers, muscles and neurons on ground with asymmetric friction."""
    figure = new_figure(
        10, 4.6, "Fig. 1A. The crawler: N viscoelastic segments, each with a muscle that one neuron drives"
    )
    axes = figure.add_subplot()
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set(xlim=(-2.0, 13.6), ylim=(-3.0, 3.35))
    _draw_ground(axes)
    for i, (left, right) in enumerate(pairwise(_NODES)):
        if i == _GAP:
            axes.text((left + right) / 2, 0.0, "· · ·", ha="center", va="center", fontsize=20, color=INK)
        else:
            _draw_segment(axes, left, right, _NODE_NAMES[i])
    for x, name in zip(_NODES, _NODE_NAMES, strict=True):
        axes.add_patch(Rectangle((x - 0.06, -0.75), 0.12, 1.95, color=INK, zorder=3))
        axes.text(x, -1.18, f"node {name}", ha="center", va="center", fontsize=9, color=INK)
    _draw_head_muscle(axes)
    _draw_coupling(axes)
    for word, height in _PARTS.items():
        axes.text(_NODES[0] - 0.25, height, word, ha="right", va="center", fontsize=9, color=INK)
    for x, word in ((_NODES[0], "tail"), (_NODES[-1], "head")):
        axes.text(x, -1.55, word, fontsize=12, fontweight="bold", ha="center", va="center", color=INK)
    return figure


def _draw_segment(axes: Axes, left: float, right: float, name: str) -> None:
    """Spring, damper and muscle in parallel between two nodes, and the neuron above them."""
    middle = (left + right) / 2
    zigzag = np.tile([0.16, -0.16], 5)
    x = np.concatenate(
        ([left, left + 0.55], np.linspace(left + 0.65, right - 0.65, 10), [right - 0.55, right])
    )
    axes.plot(x, SPRING_HEIGHT + np.concatenate(([0, 0], zigzag, [0, 0])), color=INK, lw=1.3)
    _draw_damper(axes, left, right)
    axes.plot([left, right], [MUSCLE_HEIGHT] * 2, color=MUSCLE, lw=1.5)
    axes.add_patch(Ellipse((middle, MUSCLE_HEIGHT), 0.66 * (right - left), 0.36, color=MUSCLE, zorder=4))
    _draw_neuron(axes, middle, name, MUSCLE_HEIGHT + 0.2)
    axes.text(middle, -0.62, f"segment {name}", ha="center", va="center", fontsize=8, color=GREY)


def _draw_damper(axes: Axes, left: float, right: float) -> None:
    middle, height = (left + right) / 2, DAMPER_HEIGHT
    axes.plot([left, middle - 0.1], [height] * 2, color=INK, lw=1.3)
    axes.plot([middle - 0.1] * 2, [height - 0.12, height + 0.12], color=INK, lw=2.2)
    axes.plot([middle + 0.28, right], [height] * 2, color=INK, lw=1.3)
    x = middle + np.array([-0.3, 0.28, 0.28, -0.3])
    axes.plot(x, height + np.array([0.18, 0.18, -0.18, -0.18]), color=INK, lw=1.3)


def _draw_neuron(axes: Axes, x: float, name: str, foot: float) -> None:
    """A neuron and its axon, down to the muscle."""
    _arrow(axes, (x, NEURON_HEIGHT - 0.36), (x, foot), NEURON, 1.6)
    axes.add_patch(Circle((x, NEURON_HEIGHT), 0.36, facecolor=NEURON, edgecolor=INK, lw=1, zorder=4))
    axes.text(x, NEURON_HEIGHT, name, ha="center", va="center", fontsize=10, color=INK, zorder=5)


def _draw_head_muscle(axes: Axes) -> None:
    """Muscle 0 has no segment: it pushes the head forward."""
    head = _NODES[-1]
    _draw_neuron(axes, head, "0", MUSCLE_HEIGHT + 0.3)
    _arrow(axes, (head + 0.1, MUSCLE_HEIGHT), (head + 1.25, MUSCLE_HEIGHT), MUSCLE, 5)
    said = "muscle 0 pushes\nthe head forward"
    axes.text(head + 1.4, MUSCLE_HEIGHT, said, va="center", fontsize=9, color=INK)


def _draw_coupling(axes: Axes) -> None:
    """Neuron N is ON with neuron 0."""
    tail, head, top = (_NODES[0] + _NODES[1]) / 2, _NODES[-1], 2.85
    foot = NEURON_HEIGHT + 0.36
    axes.plot([head, head, tail, tail], [foot, top, top, foot], color=GREY, lw=1.5, ls="--")
    axes.text(
        (tail + head) / 2, top + 0.15, "when neuron 0 (head) is ON, so is neuron N (tail); else just one is",
        ha="center", va="bottom", fontsize=9, color=INK,
    )  # fmt: skip


def _draw_ground(axes: Axes) -> None:
    """Ground with teeth that let a node slide forward and hold it back, and a legend."""
    left, right, top = -1.6, 12.2, -0.75
    teeth = np.arange(left, right, 0.2)
    axes.fill_between(
        np.repeat(teeth, 2), top - 0.02 - np.tile([0.0, 0.14], teeth.size), top - 0.22, color=GROUND, lw=0
    )
    y = -2.15
    _arrow(axes, (6.6, y), (8.2, y), INK, 1.5)
    axes.text(8.35, y, "forward: weak friction", va="center", fontsize=10, color=INK)
    _arrow(axes, (4.9, y), (3.3, y), INK, 5)
    axes.text(3.1, y, "backward: strong friction", va="center", ha="right", fontsize=10, color=INK)
    axes.text(
        5.3, -2.85, "node $i$ stands at $x_i = -i\\,L + u_i$; the strain of segment $i$ is $u_i - u_{i-1}$, "
        "positive when it is contracted", ha="center", fontsize=9, color=INK,
    )  # fmt: skip


def _arrow(axes: Axes, start: Point, end: Point, colour: str, width: float) -> None:
    head = f"-|>,head_length={4 + width},head_width={2 + 0.7 * width}"
    patch = FancyArrowPatch(start, end, arrowstyle=head, color=colour, lw=width, shrinkA=0, shrinkB=0)
    axes.add_patch(patch)
