"""The report on the committed results, written once."""

import pytest

from crawler_bench.report.page.folders import find_folders
from crawler_bench.report.page.write import write_report
from tests.report.test_blocks import ROOT


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The file."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    paths = [ROOT / "results" / name for name in ("paper", "benchmark", "readings")]
    write_report(find_folders([path for path in paths if path.is_dir()]), path)
    return path
