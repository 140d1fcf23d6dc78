"""`python -m crawler_bench.cli`: the command line without the command."""

from crawler_bench.cli import main

main()
