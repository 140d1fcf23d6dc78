"""Parts of a sweep: together they are all of it, and none has to wait for another."""

import itertools

import pytest

from crawler_bench.config.schema import ConfigError, RunConfig, override
from crawler_bench.runs.shards import Shard, parse_shard, part_of
from crawler_bench.runs.sweep import Cell

RUN = RunConfig(agent="random", decisions=0)
CELLS = [
    Cell("e", override(RUN, {"evaluation.mode": mode, "regularization": epsilon}, "test"), seed)
    for mode in ("deterministic", "stochastic") for epsilon in (0.0, 0.01) for seed in range(5)
]  # fmt: skip


@pytest.mark.parametrize("of", [1, 3, 16])
def test_the_parts_are_the_whole(of):
    parts = [part_of(CELLS, Shard(number, of)) for number in range(1, of + 1)]
    assert sorted(map(str, itertools.chain(*parts))) == sorted(map(str, CELLS))
    assert max(map(len, parts)) - min(map(len, parts)) <= 2
    trained = [{(cell.seed, cell.config.environment.regularization) for cell in part} for part in parts]
    assert sum(map(len, trained)) == len(set().union(*trained))  # no training in two parts


def test_a_part_is_written_as_it_is_read():
    assert str(parse_shard("3/16")) == "3/16"
    for text in ("0/3", "4/3", "3", "1/0", "a/b", "-1/3", "1/3/5", ""):
        with pytest.raises(ConfigError, match="write which part of how many"):
            parse_shard(text)
