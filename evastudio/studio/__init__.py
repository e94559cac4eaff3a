"""The 3D view of a stage, through viser."""
