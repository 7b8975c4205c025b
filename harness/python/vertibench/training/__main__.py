"""`python -m vertibench.training`: train, export, package, evaluate, card, curves."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from .._command import ended, whole_number

# The same instructions and kernels on every x86 processor with AVX2, so that weights don't depend on the machine. These variables
# must be set before torch is imported.
for _variable, _value in (("ATEN_CPU_CAPABILITY", "avx2"), ("ONEDNN_MAX_CPU_ISA", "AVX2"), ("MKL_CBWR", "AVX2")):
    os.environ.setdefault(_variable, _value)


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code.
    """
    own = _parser().parse_args(arguments)
    return ended(lambda: own.run(own))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m vertibench.training", description="Trains policies, and makes planners of them.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Any, about: str) -> argparse.ArgumentParser:
        own = commands.add_parser(name, help=about, description=about)
        own.set_defaults(run=run)
        return own

    train = command("train", _train, "Trains a planner; goes on where it was cut off.")
    train.add_argument("planner", help="a planner of the configuration: rl, mcl, acl")
    train.add_argument("--out", type=Path, required=True, help="the folder of the run")
    train.add_argument("--seed", type=int, default=0)
    train.add_argument("--config", default="policy", help="a name of tasks/training, or a file")
    train.add_argument("--set", action="append", default=[], metavar="FIELD=VALUE", help="changes a field of the configuration")
    train.add_argument("--until", type=whole_number, help="stop after so many steps; the configuration's where it isn't given")
    train.add_argument("--threads", type=whole_number, help="threads that step environments; all processors where it isn't given")

    train.add_argument("--clone", type=Path, metavar="DATASET", help="begin with what planners did in this dataset of demonstrations")

    export = command("export", _export, "Writes the weights of a checkpoint as planners read them, and checks them.")
    export.add_argument("run_folder", type=Path, metavar="RUN", help="the folder of a run, or of one of its checkpoints")
    export.add_argument("weights", type=Path, help="the file to write")

    package = command("package", _package, "Makes a planner of weights: a file that vertibench drives.")
    package.add_argument("weights", type=Path)
    package.add_argument("planner", type=Path, help="the file to write, e.g. my-policy.wasm")
    package.add_argument("--name", help="the planner's name; that of the file where it isn't given")
    package.add_argument("--about", default="A policy that was trained in the environments of vertibench")

    evaluate = command("evaluate", _evaluate, "Drives tasks with a checkpoint's policy, without noise.")
    evaluate.add_argument("run_folder", type=Path, metavar="RUN", help="the folder of a run, or of one of its checkpoints")
    evaluate.add_argument("--suite", help="a suite; the held-out worlds where it isn't given")
    evaluate.add_argument("--tasks", help="a selector of its tasks")

    card = command("card", _card, "Drives held-out tasks with a policy and what it must beat, and writes its card.")
    card.add_argument("run_folder", type=Path, metavar="RUN", help="the folder of a run, or of one of its checkpoints")
    card.add_argument("card", type=Path, help="the file to write, JSON")
    card.add_argument("--beside", type=Path, nargs="*", default=[], metavar="RUN", help="other runs, e.g. of an ablation")

    curves = command("curves", _curves, "Draws success on held-out worlds against steps, with intervals over seeds.")
    curves.add_argument("runs", type=Path, nargs="+", help="folders of runs, or tables that this command has written before")
    curves.add_argument("--out", type=Path, required=True, help="the picture to write, an SVG; a table comes beside it as CSV")
    return parser


def _train(own: argparse.Namespace) -> None:
    from ._run import train

    changes = dict(_pair(text) for text in own.set)
    train(own.planner, own.out, own.seed, own.config, changes, own.until, own.threads, own.clone, sys.stdout)


def _export(own: argparse.Namespace) -> None:
    from ._export import export

    print(export(own.run_folder, own.weights))


def _package(own: argparse.Namespace) -> None:
    from ._package import package

    package(own.weights, own.planner, own.name or own.planner.stem, own.about)
    print(f"{own.planner}: drive it by `vertibench --plugin {own.planner}`")


def _evaluate(own: argparse.Namespace) -> None:
    from ._run import evaluate

    print(json.dumps(evaluate(own.run_folder, own.suite, own.tasks)))


def _card(own: argparse.Namespace) -> None:
    from ._card import card

    print(card(own.run_folder, own.card, own.beside))


def _curves(own: argparse.Namespace) -> None:
    from ._curves import curves

    print(curves(own.runs, own.out))


def _pair(text: str) -> tuple[str, str]:
    from ._config import TrainingError

    field, found, value = text.partition("=")
    if not found:
        raise TrainingError(f"--set {text}", "it isn't FIELD=VALUE", "e.g. --set ppo.batch=512")
    return field, value


if __name__ == "__main__":
    sys.exit(main())
