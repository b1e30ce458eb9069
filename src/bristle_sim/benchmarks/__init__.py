"""Benchmarks: the cost of accuracy, and stability in hard cases."""
