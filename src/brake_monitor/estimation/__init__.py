"""Samples → estimates: the paper's model and the Kalman filter around it. No clock, no input or output.

In the order in which they are best read:

* `model`, the equations: `state_layout`, `wheelset`, `wagon`, and a step by them, `brake_step`;
* `kalman`, what knows no wagon: `ekf`, and `straight_line`, which makes its loops fast;
* `filter`, x and P of a wagon and what is done to them: `brake_filter`, by what `filter_lines` has made fast;
* `moment`, all other numbers of an estimator. `inputs` has what is told, `rolling` what is learned beside x, and
  `brake_work` what is added up;
* `core`, what is done with every ordinary sample. What the wagon does now: `regime_watch`; up to the sample's time:
  `prediction`; with a reading: `correction`; what is known then, in numbers: `readout`. No more than that is compiled;
* `doubts`, what core and estimator ask before they believe a reading or the model;
* `estimator`, what is done with any other sample. `input_trust` knows which signals are lost, `known_inputs` takes what
  is told otherwise than usual, `turning_points` has what changes at once, `earlier_run` takes over what was `learned`;
* `statement`, what is known in words: an `estimate`.

What `is_…`, `has_…` or `any_…` asks changes nothing. `see_…` takes what has come and may answer what that shows;
`set_…` and `enter_…` set what counts in the step to come.
"""
