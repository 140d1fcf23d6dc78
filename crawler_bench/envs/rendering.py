"""Pictures of the crawler: a larva seen from the side, as pixels or in a window."""

import os
import warnings
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # pygame warns about its own build and about setuptools
    import pygame
    import pygame.freetype

from crawler_bench.envs.palette import (
    CONTRACTION_LIMIT,
    CONTRACTION_SCALE,
    EARTH,
    EARTH_INK,
    INK,
    SKIN,
    WHITE,
    Colour,
)

OVERSAMPLING = 2  # drawn so much larger, then smoothed
CAPITALS = 0.69  # size of the font (points) for a text of unit height
SLIMMEST, TALLEST = 0.3, 2.4  # width (L) and height (in heights at rest) at which the drawing stops deforming
MINUS = "\N{MINUS SIGN}"


def contraction_colour(strain: float) -> Colour:
    """Colour of a segment: blue stretched, white at rest, red contracted (strain positive)."""
    scale = np.array(CONTRACTION_SCALE, dtype=np.float64)
    at = (np.clip(strain / CONTRACTION_LIMIT, -1, 1) + 1) / 2 * (len(scale) - 1)
    red, green, blue = (round(float(np.interp(at, np.arange(len(scale)), channel))) for channel in scale.T)
    return red, green, blue


def draw_crawler(
    displacement: NDArray[np.float64], time: float, size: tuple[int, int] = (640, 200)
) -> NDArray[np.uint8]:
    """Draw the crawler from the side, its head to the right; the ground passes below it.

    A segment is as wide as it is long, and bulges so that its area stays the same.

    Args:
        displacement: (N + 1,) of each node, L.
        time: written into the picture, tau_theta.
        size: width and height of the picture, pixels.

    Returns:
        (height, width, 3) picture.
    """
    width, height = size
    surface = pygame.Surface((width * OVERSAMPLING, height * OVERSAMPLING), depth=32)
    surface.fill(WHITE)
    stage = _Stage(surface, np.asarray(displacement, dtype=np.float64))
    stage.draw_ground()
    stage.draw_body()
    stage.draw_caption(time)
    smooth = pygame.transform.smoothscale(surface, size)
    return np.array(pygame.surfarray.pixels3d(smooth).swapaxes(0, 1), dtype=np.uint8)


class _Stage:
    """A drawing in progress, in oversampled pixels: y points down, x forward."""

    def __init__(self, surface: pygame.Surface, displacement: NDArray[np.float64]) -> None:
        n = displacement.size - 1
        self.surface = surface
        self.width, self.height = surface.get_size()
        self.displacement = displacement
        self.strain = np.diff(displacement)
        self.position = displacement - np.arange(n + 1)  # x of each node, L; node 0 is the head
        self.camera = float(self.position.mean())
        self.ground = 0.80 * self.height
        # A larva is some seven times as long as it is high; a short crawler is drawn stouter.
        rest_height = max(n / 7, 0.9)
        self.scale = min(self.width / (n + 3.6), 0.64 * self.height / (TALLEST * rest_height))
        self.rest_height = rest_height * self.scale
        self.line = max(round(self.height / 130), 2)

    def x(self, position: float) -> float:
        """Pixel column of a place on the ground (L)."""
        return self.width / 2 + (position - self.camera) * self.scale

    def write(self, text: str, place: tuple[float, float], share: float, colour: Colour, anchor: str) -> None:
        """Write a text whose height is a share of the picture's; `anchor` is a corner or edge of its box.

        A text that would be cut by the edge is left out.
        """
        pygame.freetype.init()
        font = pygame.freetype.Font(None, CAPITALS * share * self.height)
        font.kerning, font.pad = False, True  # this font's kerning leaves a gap in "centroid"
        image, _ = font.render(text, colour)
        box = image.get_rect()
        setattr(box, anchor, (round(place[0]), round(place[1])))
        if self.surface.get_rect().contains(box):
            self.surface.blit(image, box)

    def draw_ground(self) -> None:
        """Earth with a tick each L, and the place (L) at some of them."""
        pygame.draw.rect(
            self.surface, EARTH, (0, round(self.ground), self.width, self.height - round(self.ground))
        )
        pygame.draw.line(self.surface, EARTH_INK, (0, self.ground), (self.width, self.ground), self.line)
        half = self.width / 2 / self.scale
        spacing = next(step for step in (1, 2, 5, 10, 20, 50, 100) if step * self.scale > 0.3 * self.height)
        for tick in range(int(np.floor(self.camera - half)), int(np.ceil(self.camera + half)) + 1):
            labelled = tick % spacing == 0
            end = self.ground + (0.055 if labelled else 0.03) * self.height
            pygame.draw.line(
                self.surface, EARTH_INK, (self.x(tick), self.ground), (self.x(tick), end), self.line
            )
            if labelled:
                text = f"{tick} L".replace("-", MINUS)
                self.write(text, (self.x(tick), end + 0.01 * self.height), 0.10, EARTH_INK, "midtop")

    def draw_caption(self, time: float) -> None:
        """Time and place, above the body."""
        margin = 0.04 * self.height
        self.write(f"time {time:.1f} τ", (margin, margin), 0.13, INK, "topleft")
        place = f"centroid {self.displacement.mean():+.2f} L".replace("-", MINUS)
        self.write(place, (self.width - margin, margin), 0.13, INK, "topright")

    def draw_body(self) -> None:
        """Tail, segments from the tail on, and head."""
        bulge = self.rest_height * np.clip(1 / np.maximum(1 - self.strain, 1e-9), 1 / TALLEST, TALLEST)
        bulge[self.strain >= 1] = self.rest_height * TALLEST
        neighbours = np.minimum(np.append(bulge, bulge[-1]), np.insert(bulge, 0, bulge[0]))
        waist = 0.84 * neighbours  # height at each node: a fold between two segments
        nodes = self._nodes_on_screen()
        cap = min(0.5 * self.rest_height, max(0.9, 0.03 * self.strain.size) * self.scale)
        self._draw_cap(nodes[-1], -0.7 * cap, waist[-1])
        for i in reversed(range(self.strain.size)):
            colour = contraction_colour(float(self.strain[i]))
            self._draw_segment(nodes[i + 1], nodes[i], (waist[i + 1], waist[i]), bulge[i], colour)
        self._draw_cap(nodes[0], cap, waist[0])
        self._draw_face(nodes[0], cap, waist[0])
        for node in nodes:
            self._draw_foot(node)

    def _nodes_on_screen(self) -> list[float]:
        """Pixel columns of the nodes; a segment is never drawn thinner than can be seen."""
        widths = [max(near - far, SLIMMEST) for near, far in pairwise(self.position)]
        places = self.position[0] - np.insert(np.cumsum(widths), 0, 0.0)
        return [self.x(float(place)) for place in places]

    def _draw_segment(
        self, left: float, right: float, waists: tuple[float, float], bulge: float, colour: Colour
    ) -> None:
        """Fill a barrel whose mean height is `bulge`."""
        t = np.linspace(0, 1, 33)
        arch = np.sqrt(1 - (2 * t - 1) ** 2)
        straight = waists[0] + (waists[1] - waists[0]) * t
        top = straight + (bulge - sum(waists) / 2) / (np.pi / 4) * arch
        columns = left + (right - left) * t
        outline = list(zip(columns, self.ground - top, strict=True))
        pygame.draw.polygon(self.surface, colour, [(left, self.ground), *outline, (right, self.ground)])
        self._stroke([(left, self.ground), *outline, (right, self.ground)])

    def _draw_cap(self, node: float, reach: float, waist: float) -> None:
        """Round off an end of the body; reach is positive for the head."""
        angle = np.linspace(0, np.pi / 2, 25)
        columns = node + reach * np.cos(angle) ** 0.7
        top = self.ground - waist * np.sin(angle) ** 0.9
        outline = [(node, self.ground), *zip(columns, top, strict=True)]
        pygame.draw.polygon(self.surface, SKIN, outline)
        self._stroke(outline)

    def _draw_face(self, node: float, reach: float, waist: float) -> None:
        """An eye that looks ahead, and a mouth."""
        eye = (node + 0.45 * reach, self.ground - 0.62 * waist)
        size = max(0.15 * min(2 * reach, waist), 2.0)
        pygame.draw.circle(self.surface, WHITE, eye, 1.5 * size)
        pygame.draw.circle(self.surface, INK, eye, 1.5 * size, max(self.line // 2, 1))
        pygame.draw.circle(self.surface, INK, (eye[0] + 0.45 * size, eye[1]), 0.85 * size)
        angle = np.linspace(0.15 * np.pi, 0.75 * np.pi, 9)
        centre = (node + 0.55 * reach, self.ground - 0.34 * waist)
        smile = np.column_stack((np.cos(angle), np.sin(angle))) * (0.38 * reach, 0.14 * waist) + centre
        self._stroke([(float(x), float(y)) for x, y in smile])

    def _draw_foot(self, node: float) -> None:
        """The point of contact with the ground: a node."""
        size = max(0.10 * min(self.scale, self.rest_height), 1.5 * self.line)
        points = [
            (node - 1.2 * size, self.ground),
            (node + 0.5 * size, self.ground),
            (node - 0.9 * size, self.ground + size),
        ]
        pygame.draw.polygon(self.surface, INK, points)

    def _stroke(self, points: list[tuple[float, float]]) -> None:
        pygame.draw.lines(self.surface, INK, False, points, self.line)


class Window:
    """A window on the screen. When the user has closed it, it stays closed."""

    def __init__(self) -> None:
        self.closed = False
        self._clock = pygame.time.Clock()

    def update(self, picture: NDArray[np.uint8], fps: float) -> None:
        """Show a picture, then wait for as long as a frame takes."""
        if self.closed:
            return
        size = (picture.shape[1], picture.shape[0])
        pygame.display.init()
        screen = pygame.display.get_surface()
        if screen is None or screen.get_size() != size:
            screen = pygame.display.set_mode(size)
            pygame.display.set_caption("crawler-bench")
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()
            return
        pygame.surfarray.blit_array(screen, picture.swapaxes(0, 1))
        pygame.display.flip()
        self._clock.tick(fps)

    def close(self) -> None:
        """Close the window; Python goes on."""
        if not self.closed:
            self.closed = True
            pygame.display.quit()


def show(picture: NDArray[np.uint8], window: Window | None, fps: float) -> Window:
    """Show a picture in a window on the screen.

    Args:
        picture: (height, width, 3).
        window: what the call before returned, or None to open a window.
        fps: pictures per second, at most.

    Returns:
        The window, for the next call; it has a method `close`.
    """
    window = window or Window()
    window.update(picture, fps)
    return window
