"""What a person configures, and where it is read: TOML in, one typed object out, or one clear sentence."""
