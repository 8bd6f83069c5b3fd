"""Samples → estimates: the paper's model and the Kalman filter around it. No clock, no input or output."""
