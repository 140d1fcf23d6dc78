"""The command that shows a trained crawler live: watch."""

import os
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crawler_bench.cli import names
from crawler_bench.cli.options import Trust
from crawler_bench.cli.runs import WHAT
from crawler_bench.cli.terminal.console import console, starting

if TYPE_CHECKING:
    from crawler_bench.runs.live import Live

SIZE = (960, 300)  # pixels
FRAMES = 25  # per second
NOISE_STEP = 0.05
FASTEST = 64  # decisions per frame
KEYS = "up, down: noise   k: kick   left, right: slower, faster   space: pause   q: quit"


def watch(
    run: Annotated[str, typer.Argument(help=WHAT, autocompletion=names.policies)],
    stochastic: Annotated[bool, typer.Option(help="Draw actions instead of taking the best.")] = False,
    noise: Annotated[float, typer.Option(min=0, help="Largest error of a sensed strain, at first.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="Of draws, noise and kicks.")] = 0,
    seconds: Annotated[float, typer.Option(min=0, help="Close after this time; 0 stays open.")] = 0.0,
    trust: Trust = False,
) -> None:
    """Show a trained crawler in a window, live; keys change the noise and kick it."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    path = names.find_run(run)
    with starting(f"watching {run}"):
        from crawler_bench.runs.live import live
    crawler = live(path, "stochastic" if stochastic else "deterministic", seed, trust)
    crawler.noise = noise
    console.print(KEYS, markup=False)
    _show(crawler, run, round(seconds * FRAMES))


def _show(crawler: "Live", title: str, frames: int) -> None:
    """Run the window until it is closed, or for a number of frames, if that is not 0."""
    import pygame

    from crawler_bench.envs.rendering import draw_crawler

    try:
        pygame.display.init()
        window = pygame.display.set_mode(SIZE)
    except pygame.error as error:
        raise RuntimeError(
            f"no window can be opened ({error}); `crawler-bench render` films the gait instead"
        ) from None
    pygame.font.init()
    pygame.display.set_caption(f"crawler-bench: {title}")
    font, clock, control = pygame.font.Font(None, 26), pygame.time.Clock(), Control()
    shown = 0
    try:
        while not control.closed and (not frames or shown < frames):
            for event in pygame.event.get():
                control.obey(event, crawler)
            for _ in range(0 if control.paused else control.decisions):
                crawler.advance()
            picture = draw_crawler(crawler.displacement, crawler.time, SIZE)
            window.blit(pygame.image.frombuffer(picture.tobytes(), SIZE, "RGB"), (0, 0))
            said = f"noise {crawler.noise:.2f}   speed {1000 * crawler.speed:.2f} / 1000   {KEYS}"
            window.blit(font.render(said, True, (70, 70, 70)), (12, SIZE[1] - 28))
            pygame.display.flip()
            clock.tick(FRAMES)
            shown += 1
    finally:
        pygame.display.quit()


class Control:
    """What the keys have set.

    Attributes:
        decisions: per frame.
        paused: whether time stands still.
        closed: whether the window shall close.
    """

    def __init__(self) -> None:
        self.decisions, self.paused, self.closed = 1, False, False

    def obey(self, event: Any, crawler: "Live") -> None:
        """Do what a key, or the window's button, says."""
        import pygame

        if event.type == pygame.QUIT:
            self.closed = True
        if event.type != pygame.KEYDOWN:
            return
        if event.key in (pygame.K_q, pygame.K_ESCAPE):
            self.closed = True
        elif event.key == pygame.K_SPACE:
            self.paused = not self.paused
        elif event.key == pygame.K_k:
            crawler.kick()
        elif event.key in (pygame.K_UP, pygame.K_DOWN):
            crawler.noise += NOISE_STEP if event.key == pygame.K_UP else -NOISE_STEP
        elif event.key in (pygame.K_LEFT, pygame.K_RIGHT):
            doubled = 2 * self.decisions if event.key == pygame.K_RIGHT else self.decisions // 2
            self.decisions = min(max(doubled, 1), FASTEST)
