"""How a soft-bodied crawler learns to coordinate itself."""

__version__ = "0.1.0"
