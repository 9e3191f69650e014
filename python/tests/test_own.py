"""Things of one's own wherever names are accepted: objects, and a rider written in Python."""

import json

import numpy as np
import pytest
import twinhub

SOFT = {"tyre.front.twisting_gain": 0.5}


def test_a_bicycle_with_changes_is_one_wherever_a_bicycle_is_accepted():
    bicycle = twinhub.Bicycle("bulsink2017_bicycle1_full", SOFT)
    plain = "bulsink2017_bicycle1_full"
    np.testing.assert_array_equal(
        twinhub.linearise(bicycle, 6.0, 20.0).a, twinhub.linearise(plain, 6.0, 20.0, set=SOFT).a
    )
    speeds, torques = [4.0, 6.0], [0.0, 40.0]
    np.testing.assert_array_equal(
        twinhub.stability_map(bicycle, speeds, torques).growth_1_s,
        twinhub.stability_map(plain, speeds, torques, set=SOFT).growth_1_s,
    )
    assert twinhub.gradients(bicycle).eigenvalue == twinhub.gradients(plain, set=SOFT).eigenvalue
    long = twinhub.Bicycle("meijaard2007_benchmark", {"w": 1.2})
    assert twinhub.parameters(long)["w"] == 1.2
    modes = twinhub.modes(long, speeds_m_s=[4.0, 6.0])
    np.testing.assert_array_equal(
        modes.eigenvalues, twinhub.modes(speeds_m_s=[4.0, 6.0], set={"w": 1.2}).eigenvalues
    )
    with pytest.raises(twinhub.InputError, match="accepted: a bicycle"):
        twinhub.linearise(twinhub.Rider("older"))


def test_a_law_with_changes_is_one_for_controller_batch_and_league():
    law = twinhub.Law("constant", {"limits.torque_max_nm": 10.0})
    assert twinhub.Controller(law).to_toml() == twinhub.Controller(
        "constant", set={"limits.torque_max_nm": 10.0}
    ).to_toml()
    course = {"duration_s": 3.0}
    mild = twinhub.batch(seeds=[1], set=course, law=law)
    plain = twinhub.batch(seeds=[1], set={**course, "law": "constant", "law.limits.torque_max_nm": 10.0})
    assert mild["energy_j"] == plain["energy_j"]
    league = twinhub.league(1, controllers={"mild": law}, classes=["older"], duration_s=10.0)
    spec = json.loads(league.spec)
    limits = next(c for c in spec["controllers"] if c["name"] == "mild")["law"]["limits"]
    assert limits["torque_max_nm"] == 10.0


class Holds:
    """A rider of one's own: steers into the lean, and remembers how often it was asked."""

    asked = 0

    def __call__(self, perceived, step_s):
        Holds.asked += 1
        return -(18.0 * perceived.roll_rad + 1.0 * perceived.roll_rate_rad_s)


def test_a_rider_written_in_python_rides_in_the_league():
    small = {"riders": 1, "classes": ["older"], "duration_s": 10.0, "controllers": ["constant"]}
    own = twinhub.league(rider=Holds, **small)
    assert Holds.asked > 1000
    assert own.parts != twinhub.league(**small).parts
    assert own.parts == twinhub.league(rider=Holds, **small).parts
    with pytest.raises(twinhub.InputError, match="rider"):
        twinhub.league(rider="older", **small)


class Silent:
    def __call__(self, perceived, step_s):
        return float("nan")


def test_a_rider_that_gives_nan_ends_the_league():
    with pytest.raises(twinhub.InputError, match="rider gave"):
        twinhub.league(1, classes=["older"], controllers=["constant"], duration_s=600.0, rider=Silent)


@pytest.mark.parametrize(
    "wrong",
    [
        {"classes": "older"},
        {"classes": []},
        {"shard": 3},
        {"shard": (0, 2)},
        {"riders": 1.5},
        {"seed": "one"},
        {"controllers": {"x": 3}},
        {"duration_s": float("nan")},
    ],
)
def test_what_makes_no_league_is_refused(wrong):
    with pytest.raises(twinhub.TwinhubError):
        twinhub.league(**{"riders": 1, "controllers": ["constant"], "duration_s": 10.0, **wrong})


def test_riders_may_be_a_number_of_numpy():
    league = twinhub.league(np.int64(1), classes=["older"], controllers=["constant"], duration_s=10.0)
    assert len(league.parts) == 1


@pytest.mark.parametrize("wrong", [{"seeds": 5}, {"vary": {"duration_s": 1.0}}, {"workers": 0}, {"law": 3}])
def test_what_makes_no_batch_is_refused(wrong):
    with pytest.raises(twinhub.TwinhubError):
        twinhub.batch(**wrong)


def test_maps_modes_and_tunings_draw_themselves_with_matplotlib():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    found = twinhub.stability_map(speeds_m_s=[4.0, 6.0, 8.0], torques_nm=[0.0, 80.0])
    ax = found.plot()
    assert ax.get_xlabel() == "speed, m/s" and len(ax.collections) >= 1
    modes = twinhub.modes(speeds_m_s=[3.0, 5.0, 7.0])
    assert modes.plot(ax) is ax
    drawn = modes.plot()
    assert {line.get_label() for line in drawn.lines} >= {"weave", "capsize"}
    matplotlib.pyplot.close("all")


def test_a_study_with_changes_is_another_one_and_stands_in_no_file(tmp_path):
    plain = twinhub.Study("davis_instrumented_105")
    changed = plain.changed({"ride.0.channel.2.scale": 0.7})
    assert changed != plain and plain == twinhub.Study("davis_instrumented_105")
    assert plain.save(tmp_path / "study.toml").read_text() == plain.to_toml()
    with pytest.raises(twinhub.InputError, match="changes"):
        changed.save(tmp_path / "changed.toml")


def test_merged_shards_say_what_is_missing():
    half = twinhub.league(2, classes=["older"], controllers=["constant"], duration_s=10.0, shard=(1, 2))
    with pytest.warns(UserWarning, match="1 of 2 parts are missing"):
        twinhub.merge_leagues([half])


class Asks:
    """An optimiser that asks for what it was told to ask for."""

    def __init__(self, places):
        self.places = places

    def ask(self):
        return self.places

    def tell(self, places, values):
        pass


@pytest.mark.parametrize("places", [[], None, [0.5], [[0.5, 0.5]], [[float("nan")]], "much"])
def test_an_optimiser_that_asks_for_nothing_is_refused(places):
    bounds = {"law.limits.torque_max_nm": (0.0, 40.0)}
    with pytest.raises(twinhub.InputError, match="ask"):
        twinhub.tune(bounds=bounds, optimiser=Asks(places), set={"duration_s": 1.0}, seeds=[1])


@pytest.mark.parametrize(
    "wrong",
    [
        {"bounds": [("a", 1)]},
        {"bounds": {"law.limits.torque_max_nm": 3.0}},
        {"bounds": {"law.limits.torque_max_nm": ("a", "b")}},
        {"trials": 0},
        {"trials": 1.5},
        {"seeds": 3},
        {"seeds": []},
        {"law": 3},
    ],
)
def test_what_cannot_be_tuned_is_refused(wrong):
    with pytest.raises(twinhub.InputError):
        twinhub.tune(**{"bounds": {"law.limits.torque_max_nm": (0.0, 40.0)}, "set": {"duration_s": 1.0}, **wrong})


def test_no_trial_of_optuna_is_left_running():
    optuna = pytest.importorskip("optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study()
    bounds = {"law.limits.torque_max_nm": (0.0, 40.0)}
    twinhub.tune(bounds=bounds, optimiser=study, set={"duration_s": 1.0}, seeds=[1], trials=np.int64(3))
    assert [trial.state.name for trial in study.trials] == ["COMPLETE"] * 3
