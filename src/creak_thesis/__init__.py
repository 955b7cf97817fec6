"""The example door, and the studies of a thesis on it: what `creak example door` and `creak thesis` run.

Built on the public names of `creak`, as any program of a user is.
"""
