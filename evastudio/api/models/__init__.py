"""What travels over HTTP, field by field: one file for each room of the API."""
