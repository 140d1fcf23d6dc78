"""Speed measurements against peers and against a clock: `make speed`; see docs/performance.md."""
