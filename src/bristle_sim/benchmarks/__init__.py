"""Benchmarks: the CPU time that an accuracy costs, and the stability in hard cases."""
