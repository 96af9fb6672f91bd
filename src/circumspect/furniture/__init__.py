"""Parametric furniture of the ten ModelNet10 categories: seeded, in metres, z up."""

from circumspect.furniture.catalogue import CATEGORIES, make_furniture

__all__ = ["CATEGORIES", "make_furniture"]
