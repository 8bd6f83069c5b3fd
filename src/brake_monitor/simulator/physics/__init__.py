"""What moves the wagon: air and pads, the creep of wheels on the rail, slide protection, motors, and the train."""
