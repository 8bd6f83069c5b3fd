"""One rule a file, named like its alarm, and what several of them ask."""
