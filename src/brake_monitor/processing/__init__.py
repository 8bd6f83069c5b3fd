"""The one path from frame to estimate and alarm, live and over recordings, and what is made of estimates."""
