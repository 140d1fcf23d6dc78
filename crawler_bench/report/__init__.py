"""Generated blocks of README and docs."""
