"""Experiments as data: typed values, and the YAML files that override them."""
