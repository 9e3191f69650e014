"""What `twinhub` raises: one tree under :class:`TwinhubError`."""

__all__ = ["InputError", "LogError", "RideError", "TwinhubError", "UnknownNameError"]


class TwinhubError(Exception):
    """Base of every error of twinhub."""


class InputError(TwinhubError, ValueError):
    """An argument, a file or a value in it is wrong; the message says what would be accepted."""


class UnknownNameError(InputError, KeyError):
    """A topic or a column that is not there; the message lists those that are."""

    def __str__(self) -> str:
        # KeyError shows the repr of its argument.
        return str(self.args[0]) if self.args else ""


class LogError(TwinhubError, OSError):
    """A log cannot be written or read, or the file is no log."""


class RideError(TwinhubError, RuntimeError):
    """A ride had begun and could not go on; a fall is no error."""
