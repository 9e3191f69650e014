"""Linear models: against modes, python-control, scipy and differences."""

import numpy as np
import pytest
import twinhub


def nearest(values, others):
    return max(min(abs(a - b) for b in others) for a in values)


@pytest.mark.parametrize("torque_nm", [0.0, 40.0])
@pytest.mark.parametrize("speed_m_s", [0.0, 3.0, 5.0, 9.0])
def test_eigenvalues_are_those_of_modes(speed_m_s, torque_nm):
    model = twinhub.linearise(speed_m_s=speed_m_s, torque_nm=torque_nm)
    modes = twinhub.modes(speeds_m_s=[speed_m_s], torque_nm=torque_nm).eigenvalues[0]
    assert nearest(modes, model.eigenvalues()) < 1e-9


def test_python_control_and_scipy_agree():
    control = pytest.importorskip("control")
    for bicycle in ("meijaard2007_benchmark", "bulsink2017_bicycle1_full"):
        model = twinhub.linearise(bicycle, speed_m_s=5.0)
        theirs = model.to_control()
        assert theirs.nstates == len(model.states) and theirs.ninputs == len(model.inputs)
        assert nearest(control.poles(theirs), model.eigenvalues()) < 1e-9
        space = model.to_scipy()
        assert np.array_equal(space.A, model.a) and np.array_equal(space.B, model.b)
        # The response to a step of steer torque, exactly.
        from scipy.linalg import expm

        n, at = len(model.states), list(model.inputs).index("steer_torque_nm")
        big = np.zeros((n + 1, n + 1))
        big[:n, :n], big[:n, n] = model.a, model.b[:, at]
        response = control.step_response(theirs[:, at], np.linspace(0.0, 0.5, 51))
        exact = expm(0.5 * big)[:n, n]
        found = np.asarray(response.outputs).reshape(n, -1)[:, -1]
        assert np.abs(found - exact).max() < 1e-9 * max(1.0, np.abs(exact).max())


def test_the_matrices_are_those_of_the_paper():
    model = twinhub.linearise(speed_m_s=5.0)
    # Meijaard et al. (2007), equations 5.3 to 5.5 (g = 9.81).
    assert model.mass is not None and model.c1 is not None and model.k0 is not None and model.k2 is not None
    np.testing.assert_allclose(model.mass, [[80.81722, 2.31941332], [2.31941332, 0.29784188]], atol=1e-5)
    np.testing.assert_allclose(model.c1, [[0.0, 33.86641391], [-0.85035641, 1.68540397]], atol=1e-5)
    np.testing.assert_allclose(model.k2, [[0.0, 76.59734590], [0.0, 2.65431524]], atol=1e-5)
    np.testing.assert_allclose(model.k0, [[-80.95, -2.59951685], [-2.59951685, -0.80329488]], atol=1e-5)
    restored = -np.linalg.solve(model.mass, 9.81 * model.k0 + 25.0 * model.k2)
    np.testing.assert_allclose(model.a[2:, :2], restored, atol=1e-9)


def test_gradients_are_differences():
    found = twinhub.gradients("bulsink2017_bicycle1_full", "weave", speed_m_s=5.0)
    path = "geometry.trail_m"
    step = 1e-4

    def weave(value):
        model = twinhub.linearise("bulsink2017_bicycle1_full", 5.0, set={path: value})
        return min(model.eigenvalues(), key=lambda s: abs(s - found.eigenvalue))

    value = found.values[path]
    difference = (weave(value + step) - weave(value - step)) / (2 * step)
    assert abs(found.per_unit[path] - difference) < 1e-3 * abs(difference)
    assert path in found.values and len(found.largest(5)) == 5
    assert found.relative(path) == found.per_unit[path] * value
    with pytest.raises(twinhub.UnknownNameError, match="geometry.trail_m"):
        found.relative("geometry.trial_m")


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: twinhub.linearise(speed_m_s=-1.0), "speed_m_s"),
        (lambda: twinhub.linearise(speed_m_s=float("nan")), "speed_m_s"),
        (lambda: twinhub.linearise("no_such_bicycle"), "no_such_bicycle"),
        (lambda: twinhub.gradients(mode="wobble"), "weave"),
    ],
)
def test_bad_input_is_refused(call, told):
    with pytest.raises(twinhub.InputError, match=told):
        call()
