"""Parts of `benchmarks/crowd.py`: who walks where, how the boulder is fled, how fast it is."""
