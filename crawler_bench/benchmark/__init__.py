"""Agents against each other on one body: tables, pairs, figures."""
