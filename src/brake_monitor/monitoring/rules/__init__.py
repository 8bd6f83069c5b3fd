"""A rule for each kind of alarm, all of them in `all_rules`; what they look at is in the files beside them.

* `dragging_brake`: `participation`, `hidden_drag` after a release, `lasting_creep` over a long way;
* `friction_out_of_band`, `friction_drift`, `uneven_braking`: `per_application`, and `told_apart` by `creep_shares`;
* `low_adhesion`: `slippery_stretch`; `inputs`: `losses`; `slide`: `event_end`; `buses`: `earlier_count`.
"""
