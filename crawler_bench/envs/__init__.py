"""The crawler as a Gymnasium environment."""
