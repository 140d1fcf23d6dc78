"""Figures, films and policies as text that fits into an HTML file."""

import base64
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup
from PIL import Image

from crawler_bench.gait.record import Array

CELL = 10  # units of a square of a board


def picture(path: Path) -> tuple[str, int, int]:
    """A figure as the address of its data, and its width and height in pixels.

    Lossless WebP, at little effort, holds a figure in less than half of the bytes of a PNG.
    """
    with Image.open(path) as image:
        buffer = io.BytesIO()
        image.convert("RGB").save(buffer, "WEBP", lossless=True, quality=25, method=1)
        return _address("image/webp", buffer.getvalue()), image.width, image.height


def film(path: Path) -> str:
    """A film as the address of its data."""
    return _address("video/mp4", path.read_bytes())


def _address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def board(table: Array, words: str) -> Markup:
    """A policy as a drawing: one row per observation, one column per neuron, the diagonal framed.

    Args:
        table: (N, N) probability of each action at each observation.
        words: what it is, for someone who cannot see it.
    """
    n, parts = len(table), []
    for o, row in enumerate(table):
        for action, share in enumerate(np.sqrt(row)):  # the root tells a small share from none
            if share > 0.02:
                parts.append(
                    Markup('<rect class="on" x="{}" y="{}" width="9" height="9" opacity="{:.2f}"/>').format(
                        action * CELL, o * CELL, share
                    )
                )
    frame = [
        Markup('<rect class="diagonal" x="{0}" y="{0}" width="9" height="9"/>').format(i * CELL)
        for i in range(n)
    ]
    return Markup(
        '<svg class="board" role="img" aria-label="{}" viewBox="-1 -1 {size} {size}">{}</svg>'
    ).format(words, Markup("").join([*parts, *frame]), size=n * CELL + 1)


def one_hot(actions: Sequence[int]) -> Array:
    """(N, N) table of a policy that takes these actions."""
    table = np.zeros((len(actions), len(actions)))
    table[np.arange(len(actions)), np.asarray(actions) % len(actions)] = 1
    return table
