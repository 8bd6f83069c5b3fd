"""What programs need of the machine they run on: optional packages, whole files, processes, time that passes."""
