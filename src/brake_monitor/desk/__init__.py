"""What a person at a desk looks at, in a terminal and in files."""
