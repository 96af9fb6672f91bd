"""The commands: one module for each, with the helpers of that command beside it."""
