"""Tuning: three optimisers beat a constant pair; executors; bad input."""

import concurrent.futures

import numpy as np
import pytest
import twinhub

#: The shipped older rider at 5 m/s, straight.
RIDE = {
    "duration_s": 20.0,
    "speed": [{"t_s": 0.0, "speed_m_s": 5.0}],
    "law": "scheduled",
    "rider": "older",
}
SLOW, FAST = "law.law.scheduled.points.1.pair_nm", "law.law.scheduled.points.2.pair_nm"
BOUNDS = {SLOW: (0.0, 80.0), FAST: (0.0, 80.0)}
LIMITS = {"law.limits.torque_max_nm": 80.0}
SEEDS = (1, 2)


@pytest.fixture(scope="module")
def constant():
    return twinhub.batch(set={**RIDE, "law": "constant"}, seeds=SEEDS)


def objective(constant):
    """Energy, once the effort is that of the constant pair."""
    most_nm, full = twinhub.effort_nm(constant), twinhub.energy_wh_per_km(constant)

    def value(rides):
        over = max(0.0, twinhub.effort_nm(rides) / most_nm - 1.0)
        return twinhub.energy_wh_per_km(rides) / full + 50.0 * over + 100.0 * float(np.mean(rides["fell"]))

    return value


def powell():
    scipy = pytest.importorskip("scipy.optimize")
    return lambda f, x0, b: scipy.minimize(f, x0, bounds=b, method="Powell")


def cma():
    module = pytest.importorskip("cma")
    return module.CMAEvolutionStrategy([0.1, 0.1], 0.3, {"bounds": [0, 1], "seed": 1, "verbose": -9})


def optuna():
    module = pytest.importorskip("optuna")
    module.logging.set_verbosity(module.logging.ERROR)
    return module.create_study(sampler=module.samplers.TPESampler(seed=1))


@pytest.mark.parametrize("optimiser", [powell, cma, optuna])
def test_it_beats_a_constant_pair_from_a_poor_start(constant, optimiser):
    found = twinhub.tune(
        objective(constant),
        BOUNDS,
        optimiser(),
        start={SLOW: 2.0, FAST: 2.0},
        set={**RIDE, **LIMITS},
        seeds=SEEDS,
        trials=60,
    )
    best = found.best
    assert best.fall_share == 0.0
    assert best.effort_nm <= 1.001 * twinhub.effort_nm(constant)
    assert best.energy_wh_per_km < twinhub.energy_wh_per_km(constant)
    assert len(found.trials) <= 60
    front = found.frontier
    assert all(a.effort_nm > b.effort_nm for a, b in zip(front, front[1:], strict=False))
    assert "<svg" in found._repr_html_()


def test_without_an_optimiser_it_steps_along_the_axes():
    told = []
    found = twinhub.tune(
        bounds={SLOW: (0.0, 40.0)}, set={**RIDE, "duration_s": 3.0}, seeds=[1], trials=6, progress=told.append
    )
    assert len(told) == len(found.trials) == 6
    assert found.best.objective == min(t.objective for t in told)


def test_an_executor_gives_the_same():
    arguments = {"bounds": {SLOW: (0.0, 40.0)}, "set": {**RIDE, "duration_s": 2.0}, "seeds": [1, 2], "trials": 3}
    here = twinhub.tune(**arguments)
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        there = twinhub.tune(executor=executor, **arguments)
    assert [t.objective for t in here.trials] == [t.objective for t in there.trials]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({}, "bounds"),
        ({"bounds": {SLOW: (1.0, 0.0)}}, "least, greatest"),
        ({"bounds": {SLOW: (0.0, 1.0)}, "start": {FAST: 0.5}}, "start"),
        ({"bounds": {SLOW: (0.0, 1.0)}, "optimiser": 3}, "ask and tell"),
        ({"bounds": {SLOW: (0.0, 1.0)}, "trials": 0}, "trials"),
        ({"bounds": {"law.law.scheduled.points.1.pair_knm": (0.0, 1.0)}}, "pair_knm"),
    ],
)
def test_bad_input_is_refused(arguments, told):
    with pytest.raises(twinhub.InputError, match=told):
        twinhub.tune(**arguments)
