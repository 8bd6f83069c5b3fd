"""What a recording carries, and what in it makes one doubt its mapping: what `check` prints and a report says too."""
