"""An independent wagon: own physics, own integrator, own sensors; shares no equation with the estimator."""
