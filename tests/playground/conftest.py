"""The playground in a real browser: Chromium, headless, driven through Playwright, opened from its file.

Where there is no browser or no driver the tests are skipped and say so; with CRAWLER_BENCH_REQUIRE_BROWSER=1,
as in continuous integration, they fail instead.
"""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

import pytest

PLAYGROUND = Path(__file__).resolve().parents[2] / "docs" / "playground"
NAMES = ("chromium", "chromium-browser", "google-chrome")
# No frame rate limit: frames are counted as fast as they are made, not as fast as a screen shows them.
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-frame-rate-limit", "--disable-gpu-vsync",
)  # fmt: skip


def without_tools(why: str) -> NoReturn:
    """Skip the test, or fail where the tools have to be there."""
    if os.environ.get("CRAWLER_BENCH_REQUIRE_BROWSER") == "1":
        pytest.fail(why)
    pytest.skip(why)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A running Chromium; CRAWLER_BENCH_BROWSER names one that is not on the path."""
    path = os.environ.get("CRAWLER_BENCH_BROWSER") or next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        without_tools("no browser found: install Debian's package chromium, or set CRAWLER_BENCH_BROWSER")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        without_tools("no driver for the browser: pip install playwright")
    with sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=path, args=list(FLAGS))
        yield running
        running.close()


class Visit:
    """The playground, open in a page, and what has gone wrong in it."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.complaints: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self.complaints.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def open(self, address: str = "") -> "Visit":
        """Open the page from its file; `address` is what follows in it, from "#" on."""
        self.page.goto("about:blank")
        self.page.goto(f"{(PLAYGROUND / 'index.html').as_uri()}{address}")
        self.page.wait_for_function("page.lanes.length > 0 && page.lanes[0].samples > 0 || !page.playing")
        return self

    def run(self, script: str, argument: Any = None) -> Any:
        """The value of a JavaScript expression or function in the page."""
        return self.page.evaluate(script, argument)

    def rate(self, count: str, seconds: float = 4.0) -> float:
        """How fast a number in the page grows, per second that its own process was at work.

        Drawing is part of that work; what else the machine has to do is not.
        """
        before, began = self.run(count), self._processor_time()
        self.page.wait_for_timeout(1000 * seconds)
        return float(self.run(count) - before) / (self._processor_time() - began)

    def _processor_time(self) -> float:
        session = self.page.context.browser.new_browser_cdp_session()
        processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
        return sum(float(each["cpuTime"]) for each in processes if each["type"] == "renderer")

    @property
    def digits(self) -> str:
        """The table, or both, that the address shares."""
        return str(self.run("location.hash.slice(1)"))


@pytest.fixture
def visit(browser: Any, request: pytest.FixtureRequest) -> Iterator[Visit]:
    """The playground in a fresh context; parametrize indirectly to set the context's options."""
    options = {"viewport": {"width": 1280, "height": 900}} | getattr(request, "param", {})
    context = browser.new_context(**options)
    context.set_default_timeout(60_000)
    opened = Visit(context.new_page())
    yield opened.open()
    context.close()
    assert opened.complaints == []
    assert [url for url in opened.requests if not url.startswith(("file:", "data:", "about:"))] == []
