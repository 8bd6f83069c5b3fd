"""What is to be thought of each mapped signal, in view of what wheels, brakes and wagon do."""
