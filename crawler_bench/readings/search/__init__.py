"""The search of the joint space of readings: proposals, cheap trials, three rounds, figures."""
