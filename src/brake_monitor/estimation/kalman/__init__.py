"""A Kalman filter that knows no wagon: its equations, how well it foretells, and small matrices made quick."""
