"""The environment is registered whichever is imported first, and Gymnasium is not imported for it."""

import subprocess
import sys

import pytest

CODE = "import sys; sys.path.insert(0, {root!r}); {code}"


@pytest.mark.parametrize(
    "code",
    [
        "import crawler_bench; assert 'gymnasium' not in sys.modules and 'numpy' not in sys.modules",
        "import crawler_bench, gymnasium; gymnasium.spec('crawler_bench/Crawler-v0')",
        "import gymnasium, crawler_bench; gymnasium.spec('crawler_bench/Crawler-v0')",
        "import crawler_bench, gymnasium.envs.registration as r; r.spec('crawler_bench/Crawler-v0')",
        "import crawler_bench; from importlib.util import find_spec; find_spec('gymnasium'); "
        "import gymnasium; gymnasium.spec('crawler_bench/Crawler-v0'); assert not find_spec('numbat')",
        "import crawler_bench, importlib, gymnasium; importlib.reload(gymnasium)",
    ],
)
def test_the_environment_is_registered_in_any_order(code, request):
    words = [sys.executable, "-c", CODE.format(root=str(request.config.rootpath), code=code)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
