"""What shows and plays in a notebook."""
