"""Long runs against a real studio: kills, loads, hours. Not for every day: `make soak`."""
