"""A real browser for tests: Chromium, headless, driven through Playwright.

Where there is no browser or no driver the tests are skipped and say so; with CRAWLER_BENCH_REQUIRE_BROWSER=1,
as in continuous integration, they fail instead.
"""

import os
import shutil
from collections.abc import Iterator
from typing import Any, NoReturn

import pytest

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
