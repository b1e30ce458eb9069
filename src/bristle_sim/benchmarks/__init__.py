"""Benchmarks of the cost of accuracy, and of stability in hard cases."""
