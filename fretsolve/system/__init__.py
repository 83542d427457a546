"""The operating system: threads, signals, changes of files that survive a kill, progress on the console, optional
packages; array types.

Nothing here knows of contacts. For example, ``with atomic_files.new_file(path) as file: file.write(data)`` replaces a
file in one step.
"""
