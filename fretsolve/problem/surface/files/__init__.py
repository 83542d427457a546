"""Read measured maps: a file comes in, a `RawMap` goes out, as the file has it. One reader per kind of file."""
