"""Builds the Python package: maturin's build backend (PEP 517), and what it doesn't do.

A wheel has the module in Rust, which maturin builds, and as its data the program `vb-harness`, the suites and vehicles
of `tasks/` and the reference planners as WASM. They are put together in a folder of their own, so that nothing is left
in the checkout. An editable install finds the same in the checkout.

Environment variables: `VB_WHEEL_HARNESS` names a program and `VB_WHEEL_PLUGINS` a folder of planners that are taken as
they are, where both would be built otherwise; `VB_WHEEL_KERNELS` names a folder of kernels for GPUs, without which there are
none in the wheel; `SOURCE_DATE_EPOCH` is the time that the files in archives get.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _sdist, _stage, _wheel

Settings = Mapping[str, Any] | None


def build_wheel(wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None) -> str:
    """Makes the wheel, and tags it with the systems on which both the module and the program run."""
    import maturin

    out = os.path.abspath(wheel_directory)
    with tempfile.TemporaryDirectory() as folder:
        _stage.package(Path(folder))
        with _chdir(folder):
            # The metadata that were made before lack the licences, which lie in this folder only.
            name = maturin.build_wheel(folder, config_settings)
        # It leaves its own there, too, which nobody should take for the finished one.
        (_stage.target() / "wheels" / name).unlink(missing_ok=True)
        return _wheel.finish(Path(folder, name), Path(out))


def build_sdist(sdist_directory: str, config_settings: Settings = None) -> str:
    """Makes an archive from which a Rust toolchain alone makes the wheel."""
    import maturin

    out = os.path.abspath(sdist_directory)
    with tempfile.TemporaryDirectory() as folder:
        _stage.description(Path(folder))
        with _chdir(folder):
            metadata = Path(folder, maturin.prepare_metadata_for_build_wheel(folder, config_settings), "METADATA")
        return _sdist.make(Path(out), metadata.read_bytes())


def build_editable(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Makes a wheel that leads to the checkout, where program, tasks and planners are found."""
    import maturin

    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: Settings = None) -> str:
    """The metadata without the wheel."""
    import maturin

    return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


@contextlib.contextmanager
def _chdir(folder: str):
    # contextlib has it from Python 3.11 on.
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
