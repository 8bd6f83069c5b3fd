"""What a vehicle's sensors can tell about friction and adhesion at all: the map (16), in tables and a figure."""
