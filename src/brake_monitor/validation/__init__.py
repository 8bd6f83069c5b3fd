"""The accuracy campaign: many simulated brakings, every estimate held against the truth."""
