"""What outlives the daemon: its memory in SQLite, and the evidence of each alarm."""
