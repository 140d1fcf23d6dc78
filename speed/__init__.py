"""Speed measurements against peers: `python -m speed`, or `make bench`; see docs/performance.md."""
