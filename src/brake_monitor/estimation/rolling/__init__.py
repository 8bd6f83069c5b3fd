"""What free rolling teaches: the radius of each wheel, and how much the line undulates."""
