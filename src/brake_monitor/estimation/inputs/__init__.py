"""What is told of a wheelset between and beside its samples: the instant, the force, the contact, the protection."""
