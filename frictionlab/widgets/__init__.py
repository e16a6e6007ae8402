"""What shows, moves and plays in a notebook: explorers, a live canvas, sound."""
