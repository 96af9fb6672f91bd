"""Where to look from next, and how to get there."""
