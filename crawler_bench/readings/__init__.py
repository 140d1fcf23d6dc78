"""Every reading of the paper against every claim."""
