"""What is recorded of the brake units: applications, wear of the pads, heat of the discs."""
