"""Bicycles, riders, tyres and their like as objects."""

import numpy as np
import pytest
import twinhub

KINDS = [
    twinhub.Bicycle,
    twinhub.Course,
    twinhub.Law,
    twinhub.Motors,
    twinhub.Rider,
    twinhub.Road,
    twinhub.Scenario,
    twinhub.Sensors,
    twinhub.Study,
    twinhub.Tyre,
    twinhub.Wind,
]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_what_ships_can_be_made_and_saved(kind, tmp_path):
    names = kind.names()
    assert names
    for name in names[:3]:
        thing = kind(name)
        assert thing.values and thing.to_toml() and thing == kind(name)
        assert thing.save(tmp_path / "mine.toml").read_text() == thing.to_toml()
    with pytest.raises(twinhub.InputError, match=names[0]):
        kind("no_such_name")


def test_values_are_changed_by_path_and_read_by_path():
    rider = twinhub.Rider("older", rider__steer_torque__delay_s=0.25)
    assert rider["rider.steer_torque.delay_s"] == 0.25
    assert rider["rider.steer_torque.gains.0.speed_m_s"] == 3.0
    other = rider.changed({"rider.steer_torque.delay_s": 0.3})
    assert other["rider.steer_torque.delay_s"] == 0.3 and rider["rider.steer_torque.delay_s"] == 0.25
    assert rider != other and "0.25" in repr(rider)
    with pytest.raises(twinhub.UnknownNameError, match="delay_s"):
        rider["rider.steer_torque.delay_ms"]
    with pytest.raises(twinhub.InputError, match="delay_ms"):
        twinhub.Rider("older", rider__steer_torque__delay_ms=0.25)
    with pytest.raises(twinhub.InputError, match="delay_s"):
        twinhub.Rider("older", rider__steer_torque__delay_s=25.0)


def test_things_ride_as_the_same_values_by_set():
    short = {"duration_s": 1.0}
    things = twinhub.ride(
        set=short,
        rider=twinhub.Rider("young", rider__steer_torque__delay_s=0.15),
        law=twinhub.Law("constant", law__constant__pair_nm=15.0),
        road=twinhub.Road("dry", friction_ratio=0.7),
        motors="ideal",
        bicycle=twinhub.Bicycle("bulsink2017_bicycle1_full", geometry__trail_m=0.05),
    )
    by_set = twinhub.ride(
        set={
            **short,
            "rider": "young",
            "rider.rider.steer_torque.delay_s": 0.15,
            "law": "constant",
            "law.law.constant.pair_nm": 15.0,
            "plant.multibody.road": "dry",
            "plant.multibody.road.friction_ratio": 0.7,
            "motors": "ideal",
            "plant.multibody.set.geometry.trail_m": 0.05,
        }
    )
    assert things.digest == by_set.digest
    with pytest.raises(twinhub.InputError, match="road"):
        twinhub.ride(road=twinhub.Wind("still"))


def test_a_saved_thing_is_a_name(tmp_path):
    law = twinhub.Law("constant", law__constant__pair_nm=15.0)
    file = law.save(tmp_path / "mine.toml")
    named = twinhub.ride(set={"duration_s": 1.0}, law=file)
    assert named.metrics == twinhub.ride(set={"duration_s": 1.0}, law=law).metrics


def test_a_rider_keeps_a_bicycle_up_or_not():
    growth = twinhub.Rider("older").growth(speeds_m_s=[4.0, 5.0], pair_nm=20.0)
    assert (growth["growth_1_s"] < 0.0).all()
    printed = twinhub.Rider("bulsink2017_steer_torque_older").growth(speeds_m_s=[4.0, 5.0])
    assert (printed["growth_1_s"] > 0.0).all()


def test_a_tyre_pushes_against_its_slip():
    tyre = twinhub.Tyre(twinhub.Tyre.names()[0])
    forces = tyre.forces(slip_angle_rad=np.linspace(-0.05, 0.05, 5), load_n=[[300.0], [500.0]])
    assert forces["lateral_n"].shape == (2, 5)
    side = forces["lateral_n"][0]
    assert side[0] == pytest.approx(-side[-1], rel=0.2) and side[0] * side[-1] < 0.0
    with pytest.raises(twinhub.InputError, match="broadcast"):
        tyre.forces(slip_angle_rad=[0.0, 0.1], load_n=[1.0, 2.0, 3.0])
    with pytest.raises(twinhub.InputError, match="finite"):
        tyre.forces(load_n=float("nan"))


def test_a_scenario_runs():
    run = twinhub.Scenario("push_7ms_pair", {"duration_s": 0.5, "disturbance.0.start_s": 0.2}).run()
    assert not run.summary["fell"] and run["t_s"][-1] == pytest.approx(0.5)
    assert np.isfinite(run["roll_rad"]).all() and np.abs(run["roll_rad"]).max() > 0.0
