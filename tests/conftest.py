"""What all tests share: one browser per process, because Playwright runs only once in each."""

from tests.browser import browser  # noqa: F401  (a fixture)
