"""What shipped scenes are made of: a ship, rocks, a square, a boulder, and how people there go."""
