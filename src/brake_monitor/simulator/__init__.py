"""An independent wagon: own physics, own integrator, own sensors; shares no equation with the estimator.

What is to happen (`scenarios`, `journey`, `ordinary_service`, `troubles`) → what the wagon is (`true_vehicle`) and does
(`plant`, with its `physics`) → what its bus carries (`sensors`, `can_encoder`); `simulate` runs all of it. Which alarms
that makes `due`.
"""
