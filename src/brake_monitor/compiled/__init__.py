"""The estimator's steps as machine code, for recordings at a desk; a gateway has no numba."""
