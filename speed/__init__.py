"""Speed measurements against peers: `python -m benchmarks`, or `make bench`; see docs/performance.md."""
