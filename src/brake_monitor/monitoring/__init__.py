"""Estimates → statements about the vehicle. No clock, no input or output: time is the estimates'.

Ten times a second (`Pipeline._observe`): `inputs/` judges every mapped signal beside what wheels, brakes and wagon do;
`brake_units/` keeps the books of the brakes; an `Observation` holds what both say, and the estimate. Each of `rules/`
judges it, and an `AlarmCycle` makes the life of an alarm of the verdicts. What misleads the estimates themselves goes
back to who gives them out (`misled`).
"""
