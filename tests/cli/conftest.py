"""What tests of commands share."""

from tests.runs.conftest import marker  # noqa: F401  (a fixture)
