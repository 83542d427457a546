"""The lines that commands print. In come a setup, states or outcomes; lines go out, as text or, for programs, as JSON.

from fretsolve.cli.commands.messages.run_messages import TextMessages
TextMessages(setup, out, threads, resume=False, verbose=False).start(writer)
"""
