"""The conversation with the harness: docs/worker-protocol.md."""

import os
import struct
import sys
import traceback

import msgpack

from ._data import Command, Observation, Task

PROTOCOL = 1
ABI = "0.2"
LEVELS = ("error", "warn", "info", "debug")


class Planner:
    """The base of a planner: one instance for each task.

    Class attributes say what it is; ``init`` and ``step`` what it does.
    """

    name = "planner"
    """``a-z``, ``0-9``, ``-`` and ``_``."""
    version = "0.1.0"
    authors = ()
    about = ""
    control_period = 0.1
    """Wanted time between two steps, s; a multiple of 0.001."""
    params = {}
    """Parameters that a user may set: name to (default, help)."""
    needs = ()
    """Sensors to be read, and how many times a second: ``("pose", "lidar 10")``. Pose and wheels at every step if empty."""
    needs_without_maps = ()
    """The same, in addition, where the perception profile leaves out one of the task's maps."""
    models = ()
    """Learned weights that it has, as texts with their hashes: ``("hills.npz sha256 …, learned from …",)``."""

    def init(self, task):
        """Called once with the :class:`Task`. What it raises ends the task."""

    def step(self, obs):
        """Called every control period with the :class:`Observation`; returns a :class:`Command`."""
        raise NotImplementedError("a planner needs a method step(self, obs)")

    def log(self, message, level="info"):
        """Appends a line to the task's log; level is error, warn, info or debug."""
        if level not in LEVELS:
            raise ValueError(f"the level of a line of the log is {level!r}; it must be one of {', '.join(LEVELS)}")
        if self._send is not None:
            self._send("log", {"level": level, "message": str(message)})

    _send = None


def main(planner):
    """Answers the harness with planners of this class until it says goodbye.

    From here on, what the program prints goes to standard error, and from there to the task's log.
    """
    if sys.stdin.isatty():
        sys.exit(f'this is a planner: start it by vb-harness --plugin "{sys.executable} {sys.argv[0]}"')
    reader = os.fdopen(os.dup(0), "rb")
    writer = os.fdopen(os.dup(1), "wb")
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    # Python has taken standard output for a pipe, and would keep lines back until a later task, or cut them apart.
    if hasattr(sys.stdout, "reconfigure"):  # unless the planner has put something of its own there
        sys.stdout.reconfigure(line_buffering=True)
    serve(planner, reader, writer)


def serve(planner, reader, writer):
    """The same as :func:`main` on two binary streams."""

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
            # All of it for the log, the last line for the record.
            traceback.print_exc()
            sys.stderr.flush()
            send("error", {"kind": "error", "message": f"{type(error).__name__}: {error}{_place(error, current)}"})


def _place(error, planner):
    """The innermost line of the planner that raised an error. One in a command that `step` has returned has none: then where `step` is."""
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
    # The harness is trusted; a map of a large world is longer than msgpack's default allows.
    return msgpack.unpackb(payload, max_bin_len=length, max_str_len=length, max_array_len=length)
