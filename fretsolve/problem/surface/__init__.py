"""The undeformed surfaces: what a case lists under `surface` comes in, the separation on a grid's cells goes out.

A measured map passes `raw_map` (what a file holds), `height_map` (in mm, by what file and case say), `map_steps` (what
the case asks for) and `separation` (on the cells).
"""
