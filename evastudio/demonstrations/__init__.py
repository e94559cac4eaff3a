"""Pairs, takes, sessions, the recorder and the session store."""
