"""`vertibench-kubernetes`: the shards of a run or a sweep as an Indexed Job of Kubernetes."""

from __future__ import annotations

import json
import sys
from typing import Any

from ._command import ended, parser, work_of
from ._shard import AGAIN
from ._work import ScaleError, Work

#: Where the volume of the results is mounted.
RESULTS = "/results"
#: Exit codes of a shard that another try can't mend: what is wrong with it is wrong with all.
_FATAL = [1, 2, 3, 10]


def manifests(work: Work, name: str, image: str, claim: str, cpus: int, at_a_time: int, retries: int) -> list[dict[str, Any]]:
    """The jobs: one that drives the shards, and one that joins them, to be created when the first is complete.

    `claim` is a PersistentVolumeClaim that many pods can write to; it is mounted as `/results`, below which `work.out` lies. What the
    command line names must be in `image` or on the volume.
    """
    if not work.out.is_relative_to(RESULTS):
        raise ScaleError("--out", f"{work.out} isn't on the volume", f"give a folder below {RESULTS}")
    drive = _job(name, image, claim, cpus, ["vertibench", *work.shard(None, cpus)])
    drive["spec"].update(
        completions=work.shards,
        parallelism=min(at_a_time, work.shards),
        completionMode="Indexed",
        backoffLimitPerIndex=retries,
        # The job fails when what is left can't make it whole.
        maxFailedIndexes=0,
        podFailurePolicy={
            "rules": [
                {"action": "FailJob", "onExitCodes": {"containerName": "vertibench", "operator": "In", "values": _FATAL}},
                # Evicted pods are no failures of the shard.
                {"action": "Ignore", "onPodConditions": [{"type": "DisruptionTarget", "status": "True"}]},
                {"action": "Count", "onExitCodes": {"containerName": "vertibench", "operator": "In", "values": list(AGAIN)}},
            ]
        },
    )
    container = drive["spec"]["template"]["spec"]["containers"][0]
    # Kubernetes tells a pod its index, but not how many there are.
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
                    # A shard that is stopped puts away what it has.
                    "terminationGracePeriodSeconds": 30,
                    "containers": [container],
                    "volumes": [{"name": "results", "persistentVolumeClaim": {"claimName": claim}}],
                },
            },
        },
    }


def main(arguments: list[str] | None = None) -> int:
    """Does what the command line says; gives the exit code."""
    options = parser("vertibench-kubernetes", "Writes the Indexed Job of the shards of a run or a sweep, and the job that joins them.")
    options.add_argument("--image", required=True, help="the container image, with vertibench in it")
    options.add_argument("--claim", required=True, help="the PersistentVolumeClaim of the results, mounted as /results")
    options.add_argument("--name", default="vertibench", help="the name of the job (default: vertibench)")
    options.add_argument("--at-a-time", type=int, default=256, metavar="N", help="how many pods run at a time (default: 256)")
    options.add_argument("--retries", type=int, default=3, help="how often a shard is tried again (default: 3)")
    own = options.parse_args(arguments)

    def write() -> int:
        if own.scratch is not None:
            raise ScaleError("--scratch", "pods write to the volume", "leave it out")
        work = work_of(own)
        jobs = manifests(work, own.name, own.image, own.claim, own.cpus, own.at_a_time, own.retries)
        print(json.dumps({"apiVersion": "v1", "kind": "List", "items": jobs}, indent=2))
        return 0

    return ended(write)


if __name__ == "__main__":
    sys.exit(main())
