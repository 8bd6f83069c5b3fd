"""What is to be thought of each mapped signal: by itself, and beside what wheels, brakes and wagon do.

`input_judge` puts it together:

* each signal by itself: `lone_inputs`; why nothing good arrives of it: `refusals`;
* speeds: `wheel_watch`, by each `watched_wheelset` with what it does from reading to reading (`descent`,
  `speed_bursts`) and from one observation to the next (`turning`, `odd_turning`, `holding_force`), by the `wagon_past`,
  and by `speed_doubt` of the `vehicle_speed` and its `speed_scale`; `scatter_watch`;
* pressing forces: `force_watch`, by the `pressed_brakes`, `retardation`, creep (`force_by_creep`) and whether one fell
  alone (`fallen_force`), summed up in each `watched_force`; `frozen_forces`, `dead_forces`;
* flags of the slide protection: `flag_watch`.

`block_watch` shows them the samples of recordings, many at once.
"""
