"""Exceptions of the package."""


class Error(Exception):
    """Something that cannot be done: who it concerns, what was expected, and the way out."""


class InputError(Error, ValueError):
    """What was given cannot be used."""


class FileError(Error, OSError):
    """A file cannot be read or written."""
