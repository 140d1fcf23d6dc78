"""What tests of runs share."""

import sys

import pytest

from tests.runs.malice import EVIL


@pytest.fixture
def marker(tmp_path, monkeypatch):
    """A file that is there once a payload has run; the payload's module can be imported."""
    path = tmp_path / "marker"
    (tmp_path / "evil_agent.py").write_text(EVIL.format(marker=str(path)))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "evil_agent", raising=False)
    return path
