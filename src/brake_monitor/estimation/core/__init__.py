"""What is done with every ordinary sample; the same source runs in Python and, by `compiled`, as machine code."""
