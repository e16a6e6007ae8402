"""What is done with models: runs and their evaluation."""
