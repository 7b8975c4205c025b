"""Fleets on a GPU: what they say where there is none, and, where there is one, how they are driven by other libraries."""

import numpy as np
import pytest

import vertibench
from vertibench import _program, gpu


def on_gpu(vehicles, **options):
    """A fleet on the GPU; the test is skipped where there is none, or no kernels."""
    try:
        return gpu.Fleet(vehicles, suite="smoke", tasks="w*/t00", **options)
    except vertibench.MissingError as e:
        pytest.skip(f"kernels for a GPU are not installed: {e}")
    except vertibench.GpuError as e:
        if "libcuda, is not installed" not in str(e):
            raise
        pytest.skip(str(e))


def test_columns_and_faults_have_names():
    names = [name for name, _ in gpu.STATES]
    assert names[:4] == ["time", "x", "y", "z"] and len(names) == len(set(names)) == 20
    assert gpu.FAULTS == ("fine", "no_start", "diverged", "no_task", "no_controls")


@pytest.mark.parametrize(("in_checkout", "to_do"), [(True, "in the checkout, or set"), (False, "in a checkout of this version")])
def test_without_kernels_what_makes_them_is_told(monkeypatch, tmp_path, in_checkout, to_do):
    monkeypatch.delenv(gpu.KERNEL, raising=False)
    monkeypatch.setenv("VB_TASKS", str(vertibench.tasks_path()))
    monkeypatch.setattr(_program, "_DATA", tmp_path)
    monkeypatch.setattr(_program, "_target", lambda: tmp_path)
    monkeypatch.setattr(_program, "_in_checkout", lambda: in_checkout)
    with pytest.raises(vertibench.MissingError, match="run `cargo xtask kernel` " + to_do):
        gpu.Fleet(1, suite="smoke")


def test_packaged_kernels_are_found(monkeypatch, tmp_path):
    monkeypatch.delenv(gpu.KERNEL, raising=False)
    monkeypatch.setattr(_program, "_DATA", tmp_path)
    (tmp_path / "kernels").mkdir()
    assert _program.kernels_path() == tmp_path / "kernels"
    monkeypatch.setenv(gpu.KERNEL, str(tmp_path))
    assert _program.kernels_path() == tmp_path


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({"vehicles": 0}, "vehicles: 0"),
        ({"device": -1}, "device: -1"),
        ({"memory": -1}, "memory: -1"),
        ({"vehicles": "four"}, "vehicles: 'four'"),
        ({"vehicles": 2.5}, "vehicles: 2.5"),
        ({"device": None}, "device: None"),
        ({"memory": 10**30}, "memory: 1000"),
        ({"suite": 5}, "suite: 5 must be a name or a path"),
        ({"vehicle": 5}, "vehicle: 5 must be a name or a path"),
        ({"kernel": 5}, "kernel: 5 must be a name or a path"),
        ({"tasks": 5}, "tasks: 5 must be a selector"),
        ({"tasks": ["w001/t00", "w999/t00"]}, "w999"),
        ({"time_step": "a"}, "time_step: 'a' is not a number"),
        ({"suite": "no-suite"}, "no-suite"),
        ({"tasks": "w999/t00"}, "w999"),
        ({"vehicle": "no-vehicle"}, "no-vehicle"),
        ({"time_step": 0.003}, "time_step: 0.003 s"),
    ],
)
def test_wrong_options_are_told(options, part):
    options = {"vehicles": 4, "suite": "smoke", "tasks": "w*/t00", "kernel": "kernel.cubin", **options}
    with pytest.raises(vertibench.OptionError, match=part):
        gpu.Fleet(options.pop("vehicles"), **options)


def test_without_a_gpu_the_driver_is_asked_for():
    with pytest.raises(vertibench.GpuError) as e:
        gpu.Fleet(4, suite="smoke", tasks="w*/t00", kernel="no/kernel.cubin")
    assert "libcuda, is not installed" in str(e.value) or "no/kernel.cubin" in str(e.value)


def test_a_gpu_has_the_states_of_the_cpu():
    fleet = on_gpu(64)
    assert fleet.verify(vehicles=32, seconds=1.0) == 32
    with pytest.raises(vertibench.OptionError, match="vehicles: 0"):
        fleet.verify(vehicles=0)


def test_torch_reads_states_and_writes_controls_on_the_gpu():
    torch = pytest.importorskip("torch", reason="torch is not installed")
    fleet = on_gpu(64)
    states, controls = torch.from_dlpack(fleet.states), torch.from_dlpack(fleet.controls)
    assert states.is_cuda and states.shape == (64, 20) and states.dtype == torch.float64
    fleet.reset(torch.arange(64, device="cuda") % len(fleet.tasks))
    controls[:, 1], controls[:, 3] = 0.5, 1.0
    fleet.advance(0.5)
    assert torch.all(states[:, 0] == 0.5) and not torch.any(torch.from_dlpack(fleet.faults))
    start = torch.as_tensor(fleet.starts, device="cuda")[torch.arange(64, device="cuda") % len(fleet.tasks)]
    moved = torch.linalg.norm(states[:, 1:3] - start[:, :2], dim=1)
    assert moved.median() > 0.05 and moved.max() < 5
    # Some begin anew, told on the GPU; one is told what isn't a number, one begins a task that there isn't.
    resets = torch.from_dlpack(fleet.resets)
    assert torch.all(resets == gpu.GO_ON)
    resets[:8] = 0
    resets[9] = len(fleet.tasks)
    controls[10, 0] = float("nan")
    fleet.reset()
    fleet.advance(0.1)
    faults = torch.from_dlpack(fleet.faults).tolist()
    assert [gpu.FAULTS[faults[k]] for k in (0, 9, 10, 11)] == ["fine", "no_task", "no_controls", "fine"]
    assert torch.all(states[:8, 0] == 0.1) and torch.all(states[11:, 0] == 0.6)
    assert len({tuple(row) for row in states[:8].tolist()}) == 1
    assert len(np.unique(fleet.hashes()[:8])) == 1
    with pytest.raises(vertibench.OptionError, match="has 3 rows"):
        fleet.reset([0, 0, 0])
    with pytest.raises(vertibench.OptionError, match="whole number of steps"):
        fleet.advance(0.00015)


def test_arrays_outlive_their_fleet():
    torch = pytest.importorskip("torch", reason="torch is not installed")
    fleet = on_gpu(4)
    fleet.reset([0, 0, 0, 0])
    fleet.advance(0.1)
    states = torch.from_dlpack(fleet.states)
    seen = states.tolist()
    del fleet
    torch.zeros(1 << 20, device="cuda")
    assert states.tolist() == seen


def test_jax_and_cupy_see_the_same_memory():
    fleet = on_gpu(4)
    fleet.reset([0, 0, 0, 0])
    fleet.advance(0.1)
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    jax.config.update("jax_enable_x64", True)
    seen = np.asarray(jax.dlpack.from_dlpack(fleet.states))
    assert seen.shape == (4, 20) and np.all(seen[:, 0] == 0.1)
    cupy = pytest.importorskip("cupy", reason="CuPy is not installed")
    assert np.array_equal(cupy.asnumpy(cupy.from_dlpack(fleet.states)), seen)
