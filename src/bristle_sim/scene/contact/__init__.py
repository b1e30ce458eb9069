"""Contacts of links with obstacles: geometry, impacts, sustained contacts, and the solvers for them."""
