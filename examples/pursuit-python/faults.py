"""Telling the harness of a bug."""

from functools import wraps

from componentize_py_types import Err
from wit_world.imports.host import log
from wit_world.imports.types import LogLevel


def reported(function):
    """Lets an exception that isn't `Err` end the task as a panic with its text and place.

    Without this it ends as a trap, since there is no terminal for Python to write its traceback to.
    """

    @wraps(function)
    def call(*args):
        try:
            return function(*args)
        except Err:
            raise
        except Exception as e:
            place = e.__traceback__
            while place.tb_next is not None:
                place = place.tb_next
            file = place.tb_frame.f_code.co_filename.rsplit("/", 1)[-1]
            # The form by which the harness knows it: docs/abi.md.
            log(LogLevel.ERROR, f"panicked at {file}:{place.tb_lineno}:1: {type(e).__name__}: {e}")
            raise

    return call
