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
    parser = argparse.ArgumentParser(prog="python -m vertibench.training", description="Trains policies and makes planners from them.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Any, about: str) -> argparse.ArgumentParser:
        own = commands.add_parser(name, help=about, description=about)
        own.set_defaults(run=run)
        return own

    train = command("train", _train, "Trains a planner; continues an interrupted training.")
    train.add_argument("planner", help="planner of the configuration: rl, mcl, acl")
    train.add_argument("--out", type=Path, required=True, help="folder of the run")
    train.add_argument("--seed", type=int, default=0)
    train.add_argument("--config", default="policy", help="name in tasks/training, or file (default: policy)")
    train.add_argument("--set", action="append", default=[], metavar="FIELD=VALUE", help="replaces a field of the configuration")
    train.add_argument("--until", type=whole_number, help="environment steps at which to stop (default: the configuration's)")
    train.add_argument("--threads", type=whole_number, help="threads that step environments (default: number of processors)")

    train.add_argument("--clone", type=Path, metavar="DATASET", help="clone the demonstrations in this dataset first")

    export = command("export", _export, "Writes the weights of a checkpoint in the planners' format, and verifies them.")
    export.add_argument("run_folder", type=Path, metavar="RUN", help="folder of a run or of a checkpoint")
    export.add_argument("weights", type=Path, help="file to write")

    package = command("package", _package, "Makes a planner from weights: a file for `vertibench run`.")
    package.add_argument("weights", type=Path)
    package.add_argument("planner", type=Path, help="file to write, e.g. my-policy.wasm")
    package.add_argument("--name", help="name of the planner (default: name of the file)")
    package.add_argument("--about", default="A policy trained in the environments of vertibench")

    evaluate = command("evaluate", _evaluate, "Runs tasks with the policy of a checkpoint, without noise.")
    evaluate.add_argument("run_folder", type=Path, metavar="RUN", help="folder of a run or of a checkpoint")
    evaluate.add_argument("--suite", help="suite (default: the held-out worlds)")
    evaluate.add_argument("--tasks", help="task selector")

    card = command("card", _card, "Compares a policy with a baseline in held-out tasks, and writes its card.")
    card.add_argument("run_folder", type=Path, metavar="RUN", help="folder of a run or of a checkpoint")
    card.add_argument("card", type=Path, help="JSON file to write")
    card.add_argument("--beside", type=Path, nargs="*", default=[], metavar="RUN", help="other runs to compare, e.g. an ablation")

    curves = command("curves", _curves, "Plots success in held-out worlds over steps, with intervals over seeds.")
    curves.add_argument("runs", type=Path, nargs="+", help="folders of runs, or tables that this command has written")
    curves.add_argument("--out", type=Path, required=True, help="SVG file to write; a CSV table is written next to it")
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
    print(f"{own.planner}: run it with `vertibench run {own.planner}`")


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
        raise TrainingError(f"--set {text}", "not FIELD=VALUE", "e.g. --set ppo.batch=512")
    return field, value


if __name__ == "__main__":
    sys.exit(main())
