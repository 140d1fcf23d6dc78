"""A gait as a film: the crawler above, the strain of its segments against time below."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import ceil, floor
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from crawler_bench.envs.palette import EARTH, EARTH_INK, INK, SKIN, WHITE
from crawler_bench.envs.rendering import draw_crawler
from crawler_bench.gait.record import Record
from crawler_bench.output.style import CONTRACTION, STRAIN_LABEL, TIME_LABEL, colour_bar, strain_kymograph

Picture = NDArray[np.uint8]

DURATION = 80.0  # tau_theta of a gait that are shown: two cycles or more
PACE = 5.0  # tau_theta per second
DPI = 100
HIDDEN = (230, 230, 230)  # colour of the future


@dataclass(frozen=True)
class Format:
    """Frames per second, and the size of a frame's parts in pixels."""

    fps: float
    width: int
    body_height: int
    panel_height: int


# Both sides of a film's frames are multiples of 16, as its encoder demands.
FILM = Format(fps=25, width=960, body_height=272, panel_height=304)
GIF = Format(fps=12.5, width=640, body_height=180, panel_height=240)


def animate(record: Record, path: Path, title: str, progress: Callable[[float], None] | None = None) -> None:
    """Write the first 80 tau_theta of a record as a film, 5 tau_theta per second.

    Args:
        record: of a gait; time and place count from its start.
        path: a file whose name ends in .gif or .mp4; its folder is made if missing.
        title: above the pictures.
        progress: is told how many pictures are drawn.

    Raises:
        ValueError: if the name ends otherwise.
    """
    if path.suffix not in (".gif", ".mp4"):
        raise ValueError(f"a film is a .gif or an .mp4, not {path.name!r}")
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".gif":
        _write_gif(_counted(_pictures(record, title, GIF), progress), path)
    else:
        _write_film(_counted(_pictures(record, title, FILM), progress), path)


def count_pictures(record: Record, suffix: str) -> int:
    """How many pictures a film of a record has."""
    return len(_moments(record, GIF if suffix == ".gif" else FILM))


def _counted(pictures: Iterator[Picture], progress: Callable[[float], None] | None) -> Iterator[Picture]:
    for number, picture in enumerate(pictures, 1):
        yield picture
        if progress is not None:
            progress(number)


def _write_gif(pictures: Iterator[Picture], path: Path) -> None:
    """Write pictures in one palette, each holding only what differs from the one before."""
    palette = Image.new("P", (1, 1))
    colours = _palette()
    palette.putpalette([*colours.ravel().tolist()])
    before, frames = None, []
    for picture in pictures:
        indices = np.asarray(Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE))
        frame = Image.fromarray(
            indices if before is None else np.where(indices == before, len(colours), indices)
        )
        frame.putpalette([*colours.ravel().tolist(), 0, 0, 0])
        frames.append(frame)
        before = indices
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=round(1000 / GIF.fps), loop=0, optimize=False,
        transparency=len(colours), disposal=1,
    )  # fmt: skip


def _palette() -> Picture:
    """(n, 3) colours that occur: those of contraction, outlines, earth and greys."""
    ramps = [
        CONTRACTION(np.linspace(0, 1, 73))[:, :3] * 255,
        np.linspace(WHITE, (0, 0, 0), 21),
        np.linspace(SKIN, INK, 9),
        np.linspace(EARTH, EARTH_INK, 9),
        np.linspace(WHITE, EARTH_INK, 7),
        CONTRACTION(np.linspace(0.05, 0.95, 8))[:, :3] * 150,
    ]
    return np.unique(np.vstack(ramps).round().astype(np.uint8), axis=0)


def _write_film(pictures: Iterator[Picture], path: Path) -> None:
    """Write H.264 in one thread and without dates, so that equal records give equal bytes."""
    same_bytes = ["-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1"]
    film: Any = imageio.get_writer(
        path, format="FFMPEG", fps=FILM.fps, codec="libx264", quality=7, output_params=same_bytes
    )  # type: ignore[arg-type, unused-ignore]
    with film:
        for picture in pictures:
            film.append_data(picture)


def _pictures(record: Record, title: str, form: Format) -> Iterator[Picture]:
    """The frames of a film, evenly spaced in time."""
    time = record.time - record.time[0]
    end = _end(record)
    count = int(np.searchsorted(time, end * (1 + 1e-9), side="right"))
    displacement = record.displacement[:count] - record.displacement[0].mean()
    panel, box = _panel(time[:count], record.strain[:count], title, form)
    for moment in _moments(record, form):
        sample = int(np.abs(time[:count] - moment).argmin())
        body = draw_crawler(displacement[sample], float(time[sample]), (form.width, form.body_height))
        shown = _reveal(panel, box, moment / end)
        yield np.vstack((shown[: box.title], body, shown[box.title :]))


def _end(record: Record) -> float:
    return min(DURATION, float(record.time[-1] - record.time[0]))


def _moments(record: Record, form: Format) -> NDArray[np.float64]:
    """Times of the pictures, from the start of the film."""
    return np.arange(0, _end(record) * (1 + 1e-9), PACE / form.fps)


@dataclass(frozen=True)
class _Box:
    """Pixels of the kymograph inside its panel, and the height of the title above it."""

    left: int
    right: int
    top: int
    bottom: int
    title: int


def _panel(
    time: NDArray[np.float64], strain: NDArray[np.float64], title: str, form: Format
) -> tuple[Picture, _Box]:
    """Title, and kymograph with its colour bar, as one picture; the film's body goes between the two."""
    width, height, heading = form.width, form.panel_height, round(0.14 * form.panel_height)
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
    canvas: Any = FigureCanvasAgg(figure)
    left, bottom, top = 58 / width, 46 / height, 1 - (heading + 10) / height
    axes = figure.add_axes((left, bottom, 1 - left - 122 / width, top - bottom))
    image = strain_kymograph(axes, time, strain)
    axes.set_xlabel(TIME_LABEL)
    axes.spines[:].set_visible(False)
    scale = figure.add_axes((1 - 108 / width, bottom, 14 / width, top - bottom))
    colour_bar(axes, image, STRAIN_LABEL, cax=scale)
    figure.text(
        0.5, 1 - heading / height / 2, title, ha="center", va="center", fontsize=12, fontweight="bold"
    )
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
    frame = axes.get_window_extent()
    return picture, _Box(
        floor(frame.x0), ceil(frame.x1), height - ceil(frame.y1), height - floor(frame.y0), heading
    )


def _reveal(panel: Picture, box: _Box, share: float) -> Picture:
    """Cover the future of the kymograph, and mark the present."""
    shown = panel.copy()
    now = box.left + round(share * (box.right - box.left))
    shown[box.top : box.bottom, now : box.right] = HIDDEN
    shown[box.top : box.bottom, max(now - 1, box.left) : min(now + 1, box.right)] = INK
    return shown
