"""Views: what a browser sees of a world, drawn with viser."""
