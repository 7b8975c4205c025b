"""Runs of planners: start, read, compare and display."""
