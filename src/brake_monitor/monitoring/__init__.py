"""Estimates → statements about the vehicle. No clock, no input or output: time is the estimates'."""
