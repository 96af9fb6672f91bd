"""Occupancy grids in the object's own frame, cylindrical and rectangular (section 3.2)."""
