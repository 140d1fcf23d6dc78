"""Learners and reference policies for the crawler."""
