"""The mechanics, muscles and neurons of the crawler: numba and numpy only."""

from crawler_bench.physics.parameters import CrawlerParameters

__all__ = ["CrawlerParameters"]
