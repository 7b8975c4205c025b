"""Registers the environments with gymnasium: at once if it is imported already, otherwise right after its import.

gymnasium 1.0 no longer calls entry points of packages, and importing it takes longer than importing the rest of the
package.
"""

from __future__ import annotations

import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import PathFinder
from types import ModuleType
from typing import Any

NAME = "VertiBench/Navigation-v0"


def register() -> None:
    """Registers `VertiBench/Navigation-v0` with gymnasium. Calling it again has no effect."""
    import gymnasium

    if NAME not in gymnasium.registry:
        gymnasium.register(
            NAME,
            entry_point="vertibench.envs:NavigationEnv",
            vector_entry_point="vertibench.envs:NavigationVectorEnv",
            # The benchmark's rules end an episode, including its time limit.
            disable_env_checker=True,
            order_enforce=False,
        )


class _WhenImported(MetaPathFinder):
    """Import finder that registers the environments after gymnasium has been executed."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if name != "gymnasium":
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def and_register(module: ModuleType) -> None:
                execute(module)
                register()
                # Not earlier: code that only looks for gymnasium without importing it also comes here.
                if self in sys.meta_path:
                    sys.meta_path.remove(self)

            spec.loader.exec_module = and_register  # type: ignore[method-assign]
        return spec


def register_when_imported() -> None:
    """Registers the environments now if gymnasium is imported, otherwise right after its import."""
    if hasattr(sys.modules.get("gymnasium"), "register"):
        register()
    elif not any(isinstance(finder, _WhenImported) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WhenImported())
