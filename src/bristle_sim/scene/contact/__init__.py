"""Contacts of links with what they can touch: geometry, impacts, sustained contacts, and what solves for them."""
