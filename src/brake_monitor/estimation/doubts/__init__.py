"""What is to be thought of readings and forces before and while the filter believes them."""
