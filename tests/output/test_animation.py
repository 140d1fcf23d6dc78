"""Films of a made-up record."""

import numpy as np
import pytest
from PIL import Image

from crawler_bench.output.animation import GIF, animate
from tests.output.samples import travelling_wave


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
