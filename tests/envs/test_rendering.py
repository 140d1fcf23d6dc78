"""The crawler as pixels, and in a window without a screen."""

import os
import subprocess
import sys

import numpy as np
import pygame
import pytest

from crawler_bench.envs.rendering import contraction_colour, draw_crawler, show


@pytest.fixture
def _no_screen(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield
    pygame.display.quit()


def share_of(picture, colour):
    return (np.abs(picture.astype(int) - colour).max(axis=2) <= 3).mean()


@pytest.mark.parametrize("n", [2, 3, 10, 50])
@pytest.mark.parametrize("size", [(640, 200), (320, 100), (801, 333)])
def test_picture_has_the_size_asked_for(n, size):
    picture = draw_crawler(np.zeros(n + 1), 0.0, size)
    assert picture.shape == (size[1], size[0], 3)
    assert picture.dtype == np.uint8
    assert picture.flags.owndata or picture.base is None


def test_picture_is_the_same_twice():
    displacement = np.random.default_rng(0).normal(scale=0.1, size=11)
    np.testing.assert_array_equal(draw_crawler(displacement, 1.0), draw_crawler(displacement, 1.0))


def test_picture_depends_on_displacement_and_time():
    rest = draw_crawler(np.zeros(11), 1.0)
    moved = np.zeros(11)
    moved[5:] = 0.3
    assert (draw_crawler(moved, 1.0) != rest).mean() > 0.01
    assert (draw_crawler(np.zeros(11), 2.0) != rest).any()


def test_letters_of_a_word_keep_together():
    """Only the two spaces of "centroid +0.00 L" part its ink by more than two fifths of a space."""
    caption = draw_crawler(np.zeros(11), 0.0, (1600, 500))[:100, 800:]
    inked = np.flatnonzero((caption < 128).all(axis=2).any(axis=0))
    gaps = np.diff(inked)
    assert (gaps > 0.4 * gaps.max()).sum() == 2


def test_ground_passes_below_a_body_that_stays_in_the_picture():
    here, there = draw_crawler(np.zeros(11), 1.0), draw_crawler(np.full(11, 0.5), 1.0)
    np.testing.assert_array_equal(here[60:155], there[60:155])
    assert (here[165:] != there[165:]).any()


@pytest.mark.parametrize("n", [2, 10, 50])
@pytest.mark.parametrize("strain", [0.3, -0.3])
def test_segments_have_the_colour_of_their_contraction(n, strain):
    displacement = np.zeros(n + 1)
    displacement[n // 2 + 1 :] = strain  # of segment n // 2 alone
    colour = contraction_colour(strain)
    assert share_of(draw_crawler(displacement, 0.0), colour) > 0.001
    assert share_of(draw_crawler(np.zeros(n + 1), 0.0), colour) == 0


def test_contracted_segments_are_narrower_and_higher():
    def extent(strain):
        displacement = np.zeros(11)
        displacement[6:] = strain
        same = (
            np.abs(draw_crawler(displacement, 0.0).astype(int) - contraction_colour(strain)).max(axis=2) <= 3
        )
        rows, columns = np.nonzero(same[:155])
        return np.ptp(columns), np.ptp(rows)

    (wide, low), (narrow, high) = extent(-0.3), extent(0.3)
    assert narrow < 0.7 * wide
    assert high > 1.4 * low


def test_scale_runs_from_blue_through_white_to_red():
    stretched, rest, contracted = (contraction_colour(strain) for strain in (-0.3, 0.0, 0.3))
    assert stretched[2] > stretched[0]
    assert min(rest) > 240
    assert contracted[0] > contracted[2]
    assert contraction_colour(2.0) == contraction_colour(0.4)
    assert contraction_colour(-2.0) == contraction_colour(-0.4)


@pytest.mark.parametrize("strain", [1.0, 1.7, -5.0])
def test_extreme_strains_are_drawn(strain):
    assert draw_crawler(np.array([0.0, 0.0, strain, strain]), 0.0).std() > 0


@pytest.mark.usefixtures("_no_screen")
def test_window_shows_the_picture_and_closes():
    picture = draw_crawler(np.zeros(11), 0.0, (320, 100))
    window = show(picture, None, 1000)
    assert show(picture, window, 1000) is window
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    np.testing.assert_array_equal(shown, picture)
    window.close()
    window.close()
    assert not pygame.display.get_init()


@pytest.mark.usefixtures("_no_screen")
def test_window_that_the_user_closed_stays_closed():
    picture = draw_crawler(np.zeros(3), 0.0, (320, 100))
    window = show(picture, None, 1000)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    window = show(picture, window, 1000)
    assert window.closed
    assert show(picture, window, 1000) is window
    assert pygame.display.get_surface() is None


@pytest.mark.usefixtures("_no_screen")
def test_window_takes_pictures_of_another_size():
    window = show(draw_crawler(np.zeros(3), 0.0, (320, 100)), None, 1000)
    show(draw_crawler(np.zeros(3), 0.0, (640, 200)), window, 1000)
    assert pygame.display.get_surface().get_size() == (640, 200)
    window.close()


def test_import_prints_nothing():
    environment = {key: value for key, value in os.environ.items() if key != "PYGAME_HIDE_SUPPORT_PROMPT"}
    done = subprocess.run(
        [sys.executable, "-c", "import crawler_bench.envs.rendering"],
        capture_output=True, text=True, check=True, env=environment, timeout=60,
    )  # fmt: skip
    assert done.stdout == ""
