"""Skeletons, clips and figures: what turns "walk, turn left" into limbs (`docs/motion.md`)."""
