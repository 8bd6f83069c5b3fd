"""Noise densities fitted to recordings, by what the readings say or by a known truth."""
