"""Makes the environments known to gymnasium, which calls this when it is imported (the entry point `gymnasium.envs`)."""

from __future__ import annotations

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
