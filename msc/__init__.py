"""Parameterized skills by manifold clustering."""
