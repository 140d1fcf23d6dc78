"""The playground in a real browser, opened from its file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PLAYGROUND = Path(__file__).resolve().parents[2] / "docs" / "playground"


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
