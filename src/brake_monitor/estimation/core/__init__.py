"""What is done with every ordinary sample, on numbers that stay in their places: as it stands, and as machine code."""
