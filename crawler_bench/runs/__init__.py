"""One run and its folder; many of them in parallel processes."""
