"""Parts of `benchmarks/real_data.py`: recordings of people, what is put into them, who learns."""
