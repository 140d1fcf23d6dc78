"""What a user sees of a command, and how it ends."""
