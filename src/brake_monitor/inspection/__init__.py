"""What a recording carries, and what in it makes one doubt its mapping; `check` prints it, and reports have it too."""
