# SPDX-License-Identifier: Apache-2.0
"""A model is a tuple of terms: each bound by name, in order, compiled together and cached."""

import copy
import math
import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba.core.event
import numpy as np
import pytest

from lce_data.channels import named_input
from lce_data.errors import LceError
from lce_model import default_model
from lce_model.kernel import compose
from lce_model.kernel.compose import SIGNAL_INDEX, kernel_of
from lce_model.kernel.generate import RECORDED, source_of_runs
from lce_model.library import THERMAL, terms
from lce_model.simulation import Stepper
from lce_model.terms import Parameter, Term, inputs_of


def constant_heating(heating: float, rate: float) -> float:
    return heating + rate


EXTRA = Term(
    "extra",
    "heat",
    "dT/dt + rate",
    (Parameter("rate", "K/s", 0.0, -1.0, 1.0, "a test", "this test"),),
    ("heating",),
    constant_heating,
)


def run(members: tuple[Term, ...], parameters: list[float]) -> np.ndarray:
    time = np.arange(0.0, 30.0, 0.01)
    out = np.empty((time.size, len(RECORDED)))
    no_inputs = np.empty((time.size, 0))
    kernel_of(members).run(time, np.ones_like(time), np.empty(0), no_inputs, 301.15, 0.0, np.array(parameters), out)
    return out[:, 0]


def test_a_term_at_its_null_value_changes_nothing_to_the_last_bit() -> None:
    ambient, lumped = THERMAL["lumped"]
    with_null = run((ambient, EXTRA, lumped), [301.15, 0.0, 30.0, 18.0])
    np.testing.assert_array_equal(with_null, run((ambient, lumped), [301.15, 30.0, 18.0]))


def test_a_term_adds_to_the_heat_balance_that_follows_it() -> None:
    ambient, lumped = THERMAL["lumped"]
    heated = run((ambient, EXTRA, lumped), [301.15, 0.1, 30.0, 18.0])
    assert heated[-1] == pytest.approx(301.15 + 31.8 * (1.0 - np.exp(-29.99 / 18.0)), rel=1e-12)


def test_the_tuple_is_ordered_by_stage() -> None:
    names = [t.name for t in terms("lumped", "dynamic")]
    assert names == ["ambient", "lumped", "branch", "dynamic", "stretch_law", "strip"]


def test_a_term_that_asks_for_what_is_not_there_is_refused() -> None:
    def odd(colour: float) -> float:
        return colour

    with pytest.raises(LceError, match="argument 'colour' of step is no signal, parameter or state"):
        Term("odd", "heat", "", (), ("heating",), odd)
    with pytest.raises(LceError, match="unknown output 'colour'"):
        Term("odd", "heat", "", (), ("colour",), constant_heating)
    with pytest.raises(LceError, match="has states memory but no start"):
        Term("odd", "heat", "", (), ("heating",), lambda heating: heating, states=("memory",))


def test_a_term_reads_what_a_user_named_and_what_is_its_own_stays_its_own() -> None:
    def humid(heating: float, input_humidity: float, input_gain: float) -> float:
        return heating + input_gain * input_humidity

    gain = Parameter("input_gain", "K/s", 0.0, -1.0, 1.0, "a test", "this test")
    term = Term("humid", "heat", "", (gain,), ("heating",), humid)
    assert inputs_of((term, EXTRA)) == (named_input("input_humidity"),)


def test_a_function_is_called_start_or_step_whatever_its_file_calls_it() -> None:
    with pytest.raises(LceError, match="argument 'colour' of start is no signal"):
        Term("odd", "heat", "", (), ("heating",), constant_heating, lambda colour: colour, states=("memory",))


def test_a_term_reads_the_time_since_the_beginning_of_the_run() -> None:
    clock = Term("clock", "sensor", "T_meas = t", (), ("measured_temperature",), lambda elapsed_time: elapsed_time)
    members = (*THERMAL["lumped"], clock)
    time, out = np.array([5.0, 5.1, 5.5, 9.0]), np.empty((4, len(RECORDED)))
    values = np.array([301.15, 30.0, 18.0])
    kernel = kernel_of(members)
    kernel.run(time, np.ones(4), np.empty(0), np.empty((4, 0)), math.nan, 0.0, values, out)
    np.testing.assert_allclose(out[:, RECORDED.index("measured_temperature")], time - 5.0, atol=1e-12)
    state, no_inputs = np.empty(kernel.state_size), np.empty(0)
    kernel.begin(math.nan, 0.0, no_inputs, values, state)
    assert state[SIGNAL_INDEX["elapsed_time"]] == 0.0
    for dt_s in np.diff(time):
        kernel.advance(1.0, dt_s, no_inputs, values, state)
    assert state[SIGNAL_INDEX["measured_temperature"]] == out[-1, RECORDED.index("measured_temperature")]


def test_parameters_check_themselves() -> None:
    with pytest.raises(LceError, match=r"not an interval"):
        Parameter("a", "1", 0.0, 1.0, -1.0, "", "")
    with pytest.raises(LceError, match=r"5 K is outside \[0, 1\] K"):
        Parameter("a", "K", 5.0, 0.0, 1.0, "", "")
    with pytest.raises(LceError, match="log scale needs a positive lower bound"):
        Parameter("a", "1", 0.5, 0.0, 1.0, "", "", "log")


def test_a_second_process_loads_what_the_first_compiled(tmp_path: Path) -> None:
    program = (
        "import numba; from lce_model import default_model; k = default_model('lumped', 'none').kernel; "
        "print(sum(sum(f.stats.cache_hits.values()) for f in (k.run, k.begin, k.advance)))"
    )
    environment = os.environ | {"LCE_CACHE_DIR": str(tmp_path)}
    hits = [
        subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    assert [h.strip() for h in hits] == ["0", "3"]


def test_a_process_compiles_a_term_once_for_all_kernels_that_call_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LCE_CACHE_DIR", str(tmp_path))  # what comes from the cache would not be seen
    once = Term("once", "heat", "", (), ("heating",), lambda heating: 2.0 * heating)
    compiled = numba.core.event.RecordingListener()
    with numba.core.event.install_listener("numba:compile", compiled):
        for members in ((*THERMAL["lumped"], once), (*THERMAL["lumped"], EXTRA, once)):
            assert callable(kernel_of(members).run)
    functions = [event.data["dispatcher"].py_func for _, event in compiled.buffer if event.is_start]
    assert functions.count(once.step) == 1
    assert [function.__name__ for function in functions].count("run") == 2


def test_of_threads_that_ask_at_once_the_first_compiles() -> None:
    members = (*THERMAL["lumped"], Term("first", "heat", "", (), ("heating",), lambda heating: heating))
    asking = threading.Barrier(4)

    def ask(_: int) -> object:
        asking.wait()
        return compose._compiled(members, source_of_runs(members))

    with ThreadPoolExecutor(4) as pool:
        modules = list(pool.map(ask, range(4)))
    assert all(module is modules[0] for module in modules)


def test_a_live_strip_is_compiled_before_its_first_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LCE_CACHE_DIR", str(tmp_path))  # what comes from the cache would not be seen
    strip = Stepper(default_model("lumped", "none").add("radiation").add("laser_droop"))
    compiled = numba.core.event.RecordingListener()
    with numba.core.event.install_listener("numba:compile", compiled):
        strip.step(1.0, 0.01)
    assert not compiled.buffer


def test_a_model_looks_its_kernel_up_once_and_leaves_it_behind_in_a_copy_for_another_process() -> None:
    model = default_model("lumped", "none")
    kernel = model.kernel
    assert vars(model)["kernel"] is kernel
    there = copy.copy(model)  # by the same protocol as a pickle
    assert "kernel" not in vars(there)
    assert there == model
    assert there.kernel is kernel
