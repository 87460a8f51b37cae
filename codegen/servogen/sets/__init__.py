"""Polyhedra, redundancy, and maximal output-admissible sets with their proofs."""
