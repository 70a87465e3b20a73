"""Whoever waits for a command is told what it does: a bar on a terminal, in a pipe a line every ten seconds.

The work runs in a child process and says what it does; the parent shows it, so that the time goes on even where the work
is inside a library. What a phase is and who counts its steps is said in `kabo.phases`.
"""
