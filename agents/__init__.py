"""Learners and reference policies for the crawler, each with the interface of a Stable-Baselines3 agent."""

PROJECT = "crawler-bench"  # tells this package from openai-agents, whose import name is the same
