"""`vertibench-kubernetes`: the shards of a run or sweep as a Kubernetes Indexed Job."""

from __future__ import annotations

import json
import sys
from typing import Any

from ._command import ended, parser, work_of
from ._shard import AGAIN
from ._work import ScaleError, Work

#: Mount point of the volume for results.
RESULTS = "/results"
#: Exit codes of a permanent error, which would occur in every shard.
_FATAL = [1, 2, 3, 10]


def manifests(work: Work, name: str, image: str, claim: str, cpus: int, at_a_time: int, retries: int) -> list[dict[str, Any]]:
    """Returns the manifests of two jobs: one for the shards, and one that joins them.

    Create the second job when the first is complete. Files named in the command line must be in the image or on the
    volume.

    Args:
        work: The run or sweep; `work.out` must be below `/results`.
        name: Name of the first job; the second has the suffix `-join`.
        image: Container image with vertibench.
        claim: PersistentVolumeClaim for the results, writable from many pods, mounted as `/results`.
        cpus: Processors per pod, also its number of parallel tasks.
        at_a_time: Maximum number of parallel pods.
        retries: Maximum number of retries per shard.

    Returns:
        The two manifests, as dictionaries.

    Raises:
        ScaleError: If `work.out` is not below `/results`.
    """
    if not work.out.is_relative_to(RESULTS):
        raise ScaleError("--out", f"{work.out} is not on the volume", f"give a folder below {RESULTS}")
    drive = _job(name, image, claim, cpus, ["vertibench", *work.shard(None, cpus)])
    drive["spec"].update(
        completions=work.shards,
        parallelism=min(at_a_time, work.shards),
        completionMode="Indexed",
        backoffLimitPerIndex=retries,
        # The job fails as soon as one shard has failed permanently.
        maxFailedIndexes=0,
        podFailurePolicy={
            "rules": [
                {"action": "FailJob", "onExitCodes": {"containerName": "vertibench", "operator": "In", "values": _FATAL}},
                # An evicted pod doesn't count as a failure.
                {"action": "Ignore", "onPodConditions": [{"type": "DisruptionTarget", "status": "True"}]},
                {"action": "Count", "onExitCodes": {"containerName": "vertibench", "operator": "In", "values": list(AGAIN)}},
            ]
        },
    )
    container = drive["spec"]["template"]["spec"]["containers"][0]
    # Kubernetes gives a pod its index, but not the number of pods.
    container["env"] = [{"name": "VB_SHARDS", "value": str(work.shards)}]
    joined = _job(f"{name}-join", image, claim, 1, ["vertibench", *work.joined()])
    joined["spec"]["backoffLimit"] = 1
    return [drive, joined]


def _job(name: str, image: str, claim: str, cpus: int, command: list[str]) -> dict[str, Any]:
    container = {
        "name": "vertibench",
        "image": image,
        "command": command,
        "resources": {"requests": {"cpu": str(cpus), "memory": f"{1 + cpus}Gi"}, "limits": {"memory": f"{2 + 2 * cpus}Gi"}},
        "volumeMounts": [{"name": "results", "mountPath": RESULTS}],
    }
    return {
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"name": name, "labels": {"app.kubernetes.io/name": "vertibench"}},
        "spec": {
            "template": {
                "metadata": {"labels": {"app.kubernetes.io/name": "vertibench"}},
                "spec": {
                    "restartPolicy": "Never",
                    # A stopped shard writes its results first.
                    "terminationGracePeriodSeconds": 30,
                    "containers": [container],
                    "volumes": [{"name": "results", "persistentVolumeClaim": {"claimName": claim}}],
                },
            },
        },
    }


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code.
    """
    options = parser("vertibench-kubernetes", "Writes the Indexed Job of the shards of a run or a sweep, and the job that joins them.")
    options.add_argument("--image", required=True, help="container image with vertibench")
    options.add_argument("--claim", required=True, help="PersistentVolumeClaim of the results, mounted as /results")
    options.add_argument("--name", default="vertibench", help="name of the job (default: vertibench)")
    options.add_argument("--at-a-time", type=int, default=256, metavar="N", help="maximum number of simultaneous pods (default: 256)")
    options.add_argument("--retries", type=int, default=3, help="maximum number of retries of a shard (default: 3)")
    own = options.parse_args(arguments)

    def write() -> int:
        if own.scratch is not None:
            raise ScaleError("--scratch", "pods write to the volume", "remove the option")
        work = work_of(own)
        jobs = manifests(work, own.name, own.image, own.claim, own.cpus, own.at_a_time, own.retries)
        print(json.dumps({"apiVersion": "v1", "kind": "List", "items": jobs}, indent=2))
        return 0

    return ended(write)


if __name__ == "__main__":
    sys.exit(main())
