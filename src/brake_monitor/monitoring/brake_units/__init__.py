"""The books of the brake units: applications, wear of the pads, heat of the discs."""
