"""How figures look, and how they become files."""

import numpy as np
import pytest
from PIL import Image

from crawler_bench.envs.rendering import contraction_colour
from crawler_bench.output.kymographs import gait
from crawler_bench.output.style import CONTRACTION, save
from tests.output.samples import travelling_wave


def test_a_figure_is_written_into_a_new_folder(tmp_path):
    save(gait(travelling_wave(duration=4), "short"), tmp_path / "new", "gait")
    with Image.open(tmp_path / "new" / "gait.png") as picture:
        assert min(picture.size) > 500
    assert (tmp_path / "new" / "gait.svg").read_text().startswith("<?xml")


def test_the_same_figure_gives_the_same_bytes(tmp_path):
    for folder in ("one", "two"):
        save(gait(travelling_wave(duration=4), "short"), tmp_path / folder, "figure")
    for suffix in ("svg", "png"):
        one, two = ((tmp_path / folder / f"figure.{suffix}").read_bytes() for folder in ("one", "two"))
        assert one == two


def test_gait_shows_its_first_120_time_units():
    late = travelling_wave(duration=300).after(100)
    axes = gait(late, "A gait").axes[2]
    low, high = axes.get_xlim()
    assert low == pytest.approx(0, abs=0.2)
    assert high == pytest.approx(120, abs=0.2)


def test_figures_and_films_colour_contraction_alike():
    for strain in (-0.4, -0.17, 0.0, 0.3, 0.4):
        of_figures = np.array(CONTRACTION((strain + 0.4) / 0.8))[:3] * 255
        np.testing.assert_allclose(of_figures, contraction_colour(strain), atol=4)
