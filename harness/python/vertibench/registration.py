"""Makes the environments known to gymnasium: at once where it is imported already, else as soon as it is.

gymnasium 1.0 calls no entry points of packages any more, and importing it takes longer than all else here together.
"""

from __future__ import annotations

import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import PathFinder
from types import ModuleType
from typing import Any

NAME = "VertiBench/Navigation-v0"


def register() -> None:
    """Registers `VertiBench/Navigation-v0`. Doing it twice does no harm."""
    import gymnasium

    if NAME not in gymnasium.registry:
        gymnasium.register(
            NAME,
            entry_point="vertibench.envs:NavigationEnv",
            vector_entry_point="vertibench.envs:NavigationVectorEnv",
            # The rules of the benchmark end an episode, the limit of its time included.
            disable_env_checker=True,
            order_enforce=False,
        )


class _WhenImported(MetaPathFinder):
    """Finds gymnasium where it is, and registers the environments after it has been executed."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if name != "gymnasium":
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def and_register(module: ModuleType) -> None:
                execute(module)
                register()
                # Not before: who only asks whether it is there finds it, too.
                if self in sys.meta_path:
                    sys.meta_path.remove(self)

            spec.loader.exec_module = and_register  # type: ignore[method-assign]
        return spec


def register_when_imported() -> None:
    """Registers the environments now if gymnasium is imported, and else right after it is."""
    if hasattr(sys.modules.get("gymnasium"), "register"):
        register()
    elif not any(isinstance(finder, _WhenImported) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WhenImported())
