"""Samples → estimates: the paper's model and the Kalman filter around it. No clock, no input or output.

In the order in which they are best read:

* the equations: `model.wagon`, and a step by them, `model.brake_step`;
* x and P, and what is done to them: `ekf`, `brake_filter`. `straight_line` makes the loops of both fast, `filter_lines`
  says of what;
* all other numbers of an estimator: `moment`, `core_numbers`;
* what is done with every ordinary sample: `core`. What the wagon does now: `regime_watch`; up to the sample's time:
  `prediction`; with a reading: `correction`. No more than that is compiled;
* what is done with any other sample: `estimator`;
* what is known: `readout`, in numbers; `statement`, in words; `estimate`.
"""
