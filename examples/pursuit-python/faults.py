"""Reports bugs to the harness."""

from functools import wraps

from componentize_py_types import Err
from wit_world.imports.host import log
from wit_world.imports.types import LogLevel


def reported(function):
    """Turns an exception other than `Err` into a panic with its text and location.

    Without this the panic would report a location in the runtime instead of that of the exception.
    """

    @wraps(function)
    def call(*args):
        try:
            result = function(*args)
        except Err:
            raise
        except Exception as e:
            place = e.__traceback__
            while place.tb_next is not None:
                place = place.tb_next
            panicked(place.tb_frame.f_code, place.tb_lineno, f"{type(e).__name__}: {e}")
            raise
        if result is None:
            panicked(function.__code__, function.__code__.co_firstlineno, f"{function.__name__} returned None")
        return result

    return call


def panicked(code, line, text):
    """Logs it in the format that the harness recognises: docs/abi.md."""
    file = code.co_filename.rsplit("/", 1)[-1]
    log(LogLevel.ERROR, f"panicked at {file}:{line}:1: {text}")
