"""Checks of readings and forces, before the filter takes them and while it goes by them."""
