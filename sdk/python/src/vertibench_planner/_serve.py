"""Communication with the harness (docs/worker-protocol.md)."""

import os
import struct
import sys
import traceback

import msgpack

from ._data import Command, Observation, Task

PROTOCOL = 1
ABI = "1.0"
LEVELS = ("error", "warn", "info", "debug")


class Planner:
    """Base class of planners. The harness creates one instance per task.

    Override ``step``, usually ``init``, and the class attributes that describe the planner.

    Attributes:
        name: Name of the planner: ``a-z``, ``0-9``, ``-`` and ``_``; default ``planner``.
        version: Version of the planner; default ``0.1.0``.
        authors: Authors, a sequence of texts; default none.
        about: Description in one line; default empty.
        control_period: Simulated time between two steps, s, a positive multiple of 0.001; default 0.1.
        params: Parameters that users can set with ``--param``: a dictionary from name to (default, help text); default
            none.
        needs: Required sensors with optional rates in Hz that divide 100, e.g. ``("pose", "lidar 10")``. Sensors are
            ``pose``, ``imu``, ``wheel-odometry``, ``gnss``, ``lidar``, ``depth`` and ``local-map``. Default: pose and
            wheels at every step.
        needs_without_maps: Additional sensors if the perception profile lacks one of the world's maps, in the form of
            ``needs``; default none.
        models: Learned weights of the planner, as texts with their hashes, e.g. ``("hills.npz sha256 …, learned from
            …",)``; default none.
    """

    name = "planner"
    version = "0.1.0"
    authors = ()
    about = ""
    control_period = 0.1
    params = {}
    needs = ()
    needs_without_maps = ()
    models = ()

    def init(self, task):
        """Prepares for a task; called once, before the first step.

        An exception ends the task as a planner error, with its text in the results.

        Args:
            task: The :class:`Task`: vehicle, maps, path, goal and parameters.
        """

    def step(self, obs):
        """Computes the command; called once per control period.

        An exception ends the task as a planner error, with its text in the results.

        Args:
            obs: The :class:`Observation`: sensor readings since the last step.

        Returns:
            The :class:`Command`, which holds until the next step.

        Raises:
            NotImplementedError: If a subclass doesn't override this method.
        """
        raise NotImplementedError("a planner needs a method step(self, obs)")

    def log(self, message, level="info"):
        """Writes a line to the task's log.

        Args:
            message: Text, or an object with a text form.
            level: ``error``, ``warn``, ``info`` (default) or ``debug``.

        Raises:
            ValueError: If the level is another one.
        """
        if level not in LEVELS:
            raise ValueError(f"the level of a line of the log is {level!r}; it must be one of {', '.join(LEVELS)}")
        if self._send is not None:
            self._send("log", {"level": level, "message": str(message)})

    _send = None


def main(planner):
    """Runs a planner class as a program for the harness; returns when the harness ends.

    From the call on, printed output goes to standard error, and from there to the task's log.

    Args:
        planner: Subclass of :class:`Planner`.

    Raises:
        SystemExit: If standard input is a terminal, i.e. the program was not started by the harness.
    """
    if sys.stdin.isatty():
        sys.exit(f'this is a planner: start it with vb-harness run "{sys.executable} {sys.argv[0]}"')
    reader = os.fdopen(os.dup(0), "rb")
    writer = os.fdopen(os.dup(1), "wb")
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    # Python treats standard output as a pipe and would buffer lines until a later task, or split them.
    if hasattr(sys.stdout, "reconfigure"):  # unless the planner has replaced it
        sys.stdout.reconfigure(line_buffering=True)
    serve(planner, reader, writer)


def serve(planner, reader, writer):
    """Runs a planner class as :func:`main`, on two binary streams.

    Args:
        planner: Subclass of :class:`Planner`.
        reader: Stream with the harness's messages.
        writer: Stream for the replies.
    """

    def send(kind, fields):
        payload = msgpack.packb({kind: fields})
        writer.write(struct.pack("<I", len(payload)) + payload)
        writer.flush()

    current = None
    while True:
        message = _receive(reader)
        if message is None:
            return
        ((kind, fields),) = message.items()
        try:
            if kind == "hello":
                send("hello", _introduction(planner))
            elif kind == "init":
                current = planner()
                current._send = send
                current.init(Task._from_wire(fields))
                send("ready", {})
            elif kind == "step":
                command = current.step(Observation._from_wire(fields))
                if not isinstance(command, Command):
                    raise TypeError(
                        f"step returned {command!r}; return a Command, as Command(steering, throttle, brake)"
                    )
                send("command", command._to_wire())
            elif kind == "drop":
                current = None
                send("dropped", {})
            elif kind == "bye":
                return
            else:
                raise ValueError(f"the harness sent `{kind}`, which this version doesn't know")
        except Exception as error:
            # The whole traceback is for the log, the last line for the record.
            traceback.print_exc()
            sys.stderr.flush()
            send("error", {"kind": "error", "message": f"{type(error).__name__}: {error}{_place(error, current)}"})


def _place(error, planner):
    """Returns the planner's innermost line in a traceback as text; the line of ``step`` if the error is in the returned
    command.
    """
    here = os.path.dirname(__file__)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if os.path.dirname(f.filename) != here]
    if frames:
        return f" ({os.path.basename(frames[-1].filename)}:{frames[-1].lineno})"
    code = getattr(getattr(planner, "step", None), "__code__", None)
    return f" (step in {os.path.basename(code.co_filename)}:{code.co_firstlineno})" if code else ""


def _introduction(planner):
    for key, declared in planner.params.items():
        if not (isinstance(declared, (tuple, list)) and len(declared) == 2):
            raise TypeError(f'params["{key}"] is {declared!r}; write {{"{key}": ({declared!r}, "what it is for")}}')
    return {
        "protocol": PROTOCOL,
        "abi": ABI,
        "name": planner.name,
        "version": planner.version,
        "authors": list(planner.authors),
        "about": planner.about,
        "control_period": float(planner.control_period),
        "params": [
            {"key": key, "default": str(default), "help": text} for key, (default, text) in planner.params.items()
        ],
        "needs": [str(need) for need in planner.needs],
        "needs_without_maps": [str(need) for need in planner.needs_without_maps],
        "models": [str(model) for model in planner.models],
    }


def _receive(reader):
    header = reader.read(4)
    if len(header) < 4:
        return None
    (length,) = struct.unpack("<I", header)
    payload = reader.read(length)
    if len(payload) < length:
        return None
    # The harness is trusted; the map of a large world exceeds msgpack's default limit.
    return msgpack.unpackb(payload, max_bin_len=length, max_str_len=length, max_array_len=length)
