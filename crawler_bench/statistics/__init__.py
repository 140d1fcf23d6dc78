"""Arrays in, estimates out: intervals over independent runs, and tests of differences."""
