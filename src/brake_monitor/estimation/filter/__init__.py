"""x and P of one wagon: where they are kept, what is known of them, and the steps that `ekf` and `model` make."""
