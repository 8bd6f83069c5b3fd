"""The paper's equations, put right: the wagon, its wheel loads, and a step of the state under what acts on it."""
