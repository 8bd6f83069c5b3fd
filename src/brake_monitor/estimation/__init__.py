"""Samples → estimates: the paper's model and the Kalman filter around it. No clock, no input or output.

In the order in which they are best read:

* `model`, the equations: `state_layout`, `wheelset`, `wagon`, and a step by them, `brake_step`;
* `filter`, x and P and what is done to them: `ekf`, which knows no wagon, and `brake_filter`. `straight_line` makes the
  loops of both fast, `filter_lines` says of what;
* `moment`, all other numbers of an estimator. A file each have what is told, `held_input` and `pad_contact`, what is
  learned beside x, `radius_calibration` and `line_roughness`, and what is added up, `brake_work` and `foretold`;
* `core`, what is done with every ordinary sample. What the wagon does now: `regime_watch`; up to the sample's time:
  `prediction`; with a reading: `correction`; what is known then, in numbers: `readout`. No more than that is compiled;
* `doubts`, what core and estimator ask before they believe a reading or the model;
* `estimator`, what is done with any other sample. `alignment` brings late ones in order, `known_inputs` takes what is
  told otherwise than usual, `friction_pause` says what pads may have done unseen, `slide_protection` sees which of them
  act, `earlier_run` goes on with what was `learned`;
* `statement`, what is known in words: an `estimate`.

What `is_…`, `has_…` or `any_…` asks changes nothing. `see_…` takes what has come and may answer what that shows;
`set_…` and `enter_…` set what counts in the step to come.
"""
