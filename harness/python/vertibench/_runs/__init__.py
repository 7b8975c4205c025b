"""Runs of planners: starting them, reading what they leave behind, comparing and showing it."""
