"""Parameters and modes: published numbers, the command line, bad input."""

import json
import os
import subprocess

import numpy as np
import pytest
import twinhub

# Meijaard et al. (2007), section 5: the speeds of the benchmark bicycle.
WEAVE_M_S = 4.29238253634111
CAPSIZE_M_S = 6.02426201538837


def test_benchmark_speeds_are_the_published_ones():
    m = twinhub.modes(bicycle="meijaard2007_benchmark", speeds_m_s=np.linspace(0.0, 10.0, 51))
    assert m.weave_speed_m_s == pytest.approx(WEAVE_M_S, rel=1e-12, abs=2e-14)
    assert m.capsize_speed_m_s == pytest.approx(CAPSIZE_M_S, rel=1e-12, abs=2e-14)
    assert (m.weave, m.capsize) == ("crosses", "crosses")
    np.testing.assert_allclose(m.stable_ranges_m_s, [[WEAVE_M_S, CAPSIZE_M_S]], rtol=1e-12)
    assert [(c.mode, c.kind, c.stable_above) for c in m.crossings] == [
        ("weave", "oscillation", True),
        ("capsize", "divergence", False),
    ]


def test_benchmark_eigenvalues_at_5_m_s():
    # Meijaard et al. (2007), table 2, v = 5 m/s.
    m = twinhub.modes(speeds_m_s=[5.0])
    weave = -0.77534188219585 + 4.46486771378823j
    expected = [-14.07838969279822, weave.conjugate(), weave, -0.32286642900409]
    np.testing.assert_allclose(m.eigenvalues[0], expected, rtol=1e-12, atol=2e-14)
    assert m.names.tolist() == [["caster", "weave", "weave", "capsize"]]


def test_shapes_order_and_branches():
    speeds = np.array([7.0, 0.0, 3.5])
    m = twinhub.modes(speeds_m_s=speeds)
    assert m.speed_m_s.tolist() == speeds.tolist()
    assert m.eigenvalues.shape == m.names.shape == (3, 4)
    assert m.eigenvalues.dtype == np.complex128
    assert (np.diff(m.eigenvalues.real, axis=1) >= 0.0).all()
    assert m.eigenvalues_of("weave").shape == (3, 2)
    assert m.eigenvalues_of("capsize").shape == m.eigenvalues_of("caster").shape == (3, 1)
    parts = [m.eigenvalues_of(mode).sum() for mode in ("weave", "capsize", "caster")]
    assert sum(parts) == pytest.approx(m.eigenvalues.sum())
    with pytest.raises(twinhub.UnknownNameError, match="capsize, caster, weave"):
        m.eigenvalues_of("wobble")


def test_a_range_without_crossing_has_no_speed():
    m = twinhub.modes(speeds_m_s=[4.5, 5.5])
    assert m.weave_speed_m_s is None and m.capsize_speed_m_s is None
    assert (m.weave, m.capsize) == ("always_stable", "always_stable")
    assert m.stable_ranges_m_s.tolist() == [[4.5, 5.5]]
    below = twinhub.modes(speeds_m_s=[1.0, 2.0])
    assert below.weave == "always_unstable"
    assert below.stable_ranges_m_s.shape == (0, 2)


def test_the_pair_moves_the_modes_and_balances():
    off = twinhub.modes(bicycle="bulsink2017_bicycle1", speeds_m_s=[4.0])
    on = twinhub.modes(bicycle="bulsink2017_bicycle1", torque_nm=20.0, speeds_m_s=[4.0])
    assert off.front_brake_nm == off.rear_traction_nm == 0.0
    p = twinhub.parameters("bulsink2017_bicycle1")
    assert on.rear_traction_nm == pytest.approx(20.0 * p["rR"] / p["rF"], rel=1e-15)
    assert on.longitudinal_accel_m_s2 == 0.0
    assert abs(on.eigenvalues - off.eigenvalues).max() > 1e-3
    alone = twinhub.modes(torque_nm=20.0, rear_torque_nm=0.0, speeds_m_s=[4.0])
    assert alone.rear_traction_nm == 0.0 and alone.longitudinal_accel_m_s2 < 0.0


def test_set_changes_a_parameter():
    values = twinhub.parameters("meijaard2007_benchmark", set={"c": 0.05})
    before = twinhub.parameters("meijaard2007_benchmark")
    assert values.pop("c") == 0.05 and before.pop("c") == 0.08
    assert values == before
    as_text = twinhub.modes(speeds_m_s=[5.0], set=["c=0.05"])
    as_number = twinhub.modes(speeds_m_s=[5.0], set={"c": np.float64(0.05)})
    assert (as_text.eigenvalues == as_number.eigenvalues).all()
    assert as_text.remarks == ("set by hand: c=0.05",)


def test_every_built_in_bicycle_has_finite_modes_and_units():
    assert {"meijaard2007_benchmark", "bulsink2017_bicycle1", "bulsink2017_bicycle2"} <= set(
        twinhub.bicycles()
    )
    for name in twinhub.bicycles():
        assert np.isfinite(twinhub.modes(bicycle=name).eigenvalues).all()
        assert list(twinhub.parameters(name)) == list(twinhub.parameter_units())
    assert twinhub.parameter_units()["IBxx"] == "kg m^2"


@pytest.mark.parametrize("rear", [None, 3.0])
def test_the_command_line_gives_the_same_numbers(rear):
    binary = os.environ.get("TWINHUB_BIN")
    if not binary:
        pytest.skip("TWINHUB_BIN does not name the twinhub command")
    command = [binary, "modes", "--bicycle", "bulsink2017_bicycle2", "--torque-nm", "12.5"]
    command += ["--speeds-m-s", "0:10:0.25", "--set", "c=0.06", "--json"]
    command += [] if rear is None else ["--rear-torque-nm", str(rear)]
    told = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    m = twinhub.modes(
        bicycle="bulsink2017_bicycle2",
        torque_nm=12.5,
        speeds_m_s=np.arange(41) * 0.25,
        rear_torque_nm=rear,
        set={"c": 0.06},
    )
    assert [p["speed_m_s"] for p in told["points"]] == m.speed_m_s.tolist()
    pairs = np.stack([m.eigenvalues.real, m.eigenvalues.imag], axis=-1).tolist()
    assert [p["eigenvalues"] for p in told["points"]] == pairs
    assert [p["modes"] for p in told["points"]] == m.names.tolist()
    assert told["stable_ranges_m_s"] == m.stable_ranges_m_s.tolist()
    for key in (
        "weave", "capsize", "weave_speed_m_s", "capsize_speed_m_s", "front_brake_nm",
        "rear_traction_nm", "longitudinal_accel_m_s2", "bicycle", "source",
    ):  # fmt: skip
        assert told[key] == getattr(m, key), key
    assert told["remarks"] == list(m.remarks)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"bicycle": "nishiki"}, "meijaard2007_benchmark, bulsink2017_bicycle1"),
        ({"bicycle": 3}, "a name or a path"),
        ({"speeds_m_s": [1.0, float("nan")]}, r"speeds_m_s\[1\] is nan"),
        ({"speeds_m_s": [1.0, float("inf")]}, r"speeds_m_s\[1\] is inf"),
        ({"speeds_m_s": [-1.0]}, r"speeds_m_s\[0\] is -1"),
        ({"speeds_m_s": [1e6]}, r"speeds_m_s\[0\] is 1000000.0; .* 0 to 1000 m/s"),
        ({"speeds_m_s": np.zeros(100_001)}, r"shape \(100001,\)"),
        ({"speeds_m_s": []}, r"shape \(0,\)"),
        ({"speeds_m_s": 5.0}, r"shape \(\)"),
        ({"speeds_m_s": [[1.0, 2.0]]}, r"shape \(1, 2\)"),
        ({"speeds_m_s": [[1.0], [1.0, 2.0]]}, "one-dimensional"),
        ({"speeds_m_s": ["5"]}, "dtype"),
        ({"speeds_m_s": [1.0 + 2.0j]}, "dtype complex"),
        ({"torque_nm": float("nan")}, "torque_nm=nan"),
        ({"torque_nm": 1e308}, "not finite at 0 m/s with 1000"),
        ({"torque_nm": "20"}, "torque_nm='20'"),
        ({"rear_torque_nm": float("inf")}, "rear_torque_nm=inf"),
        ({"set": {"ibxx": 9.2}}, "did you mean `IBxx`"),
        ({"set": {"c": "long"}}, "SYMBOL=NUMBER"),
        ({"set": {"mB": -1.0}}, "mB"),
        ({"set": {"mB": float("nan")}}, "mB"),
        ({"set": {"mB": object()}}, "a number"),
        ({"set": "c=0.05"}, "a mapping"),
        ({"set": 3}, "a mapping"),
    ],
)
def test_bad_input_says_what_is_accepted(arguments, message):
    with pytest.raises(twinhub.InputError, match=message) as caught:
        twinhub.modes(**arguments)
    assert isinstance(caught.value, (twinhub.TwinhubError, ValueError))


def test_a_bicycle_file_with_an_error_is_named_with_the_place(tmp_path):
    text = "w = 1.02\nc = 0.08+/-0.001\nlam = steep\n"
    file = tmp_path / "MineBenchmark.txt"
    file.write_text(text)
    with pytest.raises(twinhub.InputError, match=r"MineBenchmark.txt, line 3, key `lam`"):
        twinhub.parameters(file)
