"""The controller, tick by tick: bit-equal to the ride's own, bad input, laws."""

import numpy as np
import pytest
import twinhub


def test_ten_thousand_ticks_are_bit_equal_to_the_ride():
    ride = twinhub.ride(set={"duration_s": 10.5})
    again = twinhub.Controller.of(ride).replay(ride)
    said = ride["/control/output"]
    assert len(again["t_s"]) >= 10_000
    assert np.abs(said["command.front_brake_nm"]).max() > 1.0
    for ours, theirs in (
        ("front_brake_nm", "command.front_brake_nm"),
        ("rear_traction_nm", "command.rear_traction_nm"),
        ("demand_nm", "demand_nm"),
    ):
        assert again[ours].tobytes() == said[theirs].tobytes(), ours


def healthy(ms, speed_m_s=5.0):
    stamp = ms * 1_000_000
    rate = speed_m_s / 0.35
    return (
        stamp,
        twinhub.Measurement(
            imu=twinhub.ImuSample(stamp, (0.0, 0.0, 0.0), (0.0, 0.0, -9.81)),
            roll=twinhub.RollSample(stamp),
            steer=twinhub.SteerSample(stamp),
            wheels=twinhub.WheelSample(stamp, rate, rate, speed_m_s),
        ),
        twinhub.RiderIntent(stamp, assist_on=True, pedalling=True),
    )


def test_the_pair_ramps_up_and_the_lever_ends_it_at_once():
    controller = twinhub.Controller("constant")
    outputs = [controller.step(*healthy(ms)) for ms in range(4000)]
    assert outputs[-1].mode == "active" and outputs[-1].health == ()
    assert outputs[-1].front_brake_nm == pytest.approx(40.0)
    steps = np.diff([o.front_brake_nm for o in outputs])
    assert steps.max() <= 0.0201
    t, measurement, intent = healthy(4000)
    pulled = twinhub.RiderIntent(intent.stamp_ns, True, True, front_brake_ratio=0.5)
    output = controller.step(t, measurement, pulled)
    assert output.front_brake_nm == 0.0 and "lever" in output.limited_by
    controller.reset()
    assert controller.step(*healthy(0)).front_brake_nm == 0.0


def test_what_is_believed_has_an_uncertainty_and_an_age():
    controller = twinhub.Controller("constant")
    for ms in range(2000):
        controller.step(*healthy(ms))
    belief = controller.belief()
    assert belief["speed_m_s"].value == pytest.approx(5.0, abs=0.01)
    assert belief["front_load_n"].value == pytest.approx(334.0, abs=1.0)
    assert all(known.sd > 0.0 for known in belief.values())
    # No wheel has slipped, and no sensor feels the road.
    assert "friction_ratio" not in belief and belief["road_lean_rad"].age_s == np.inf
    # A front wheel that turns at half the speed under its motor.
    t_ns, m, intent = healthy(2000)
    wheels = twinhub.WheelSample(t_ns, 0.5 * m.wheels.front_rad_s, m.wheels.rear_rad_s, 5.0)
    motors = twinhub.MotorSample(t_ns, 40.0, 40.0)
    controller.step(t_ns, twinhub.Measurement(m.imu, m.roll, m.steer, wheels, motors), intent)
    friction = controller.belief()["friction_ratio"]
    asked = 40.0 / 0.35 / 334.0
    assert friction.value == pytest.approx(0.5 * asked, rel=0.01) and friction.age_s == 0.0
    controller.reset()
    assert controller.belief()["speed_m_s"].age_s == np.inf


def test_nothing_that_comes_in_gets_out_of_bounds():
    controller = twinhub.Controller("scheduled", set={"limits.torque_max_nm": 20.0})
    nan = float("nan")
    for ms in range(3000):
        t, m, intent = healthy(ms)
        if ms % 7 == 0:
            m = twinhub.Measurement(steer=twinhub.SteerSample(t, nan, 1e30), wheels=m.wheels)
        output = controller.step(t, m, intent)
        assert 0.0 <= output.front_brake_nm <= 20.0


def test_laws_and_their_files():
    assert {"off", "constant", "scheduled", "roll_steer_feedback", "steering_spring", "steering_motor"} <= set(
        twinhub.laws()
    )
    controller = twinhub.Controller("constant", set={"law.constant.pair_nm": 12.5})
    assert "pair_nm = 12.5" in controller.to_toml()
    assert controller.settled_nm(5.0) == (12.5, 12.5)
    assert repr(controller) == "Controller(constant)"


@pytest.mark.parametrize(
    ("law", "values", "told"),
    [
        ("no_such", None, "no_such"),
        ("constant", {"law.constant.pair_nm": 1000.0}, "law.constant.pair_nm"),
        ("constant", {"limits.torque_max_knm": 1.0}, "torque_max_knm"),
    ],
)
def test_a_wrong_law_is_refused_with_its_place(law, values, told):
    with pytest.raises(twinhub.InputError, match=told):
        twinhub.Controller(law, set=values)


def test_what_is_no_message_is_refused():
    controller = twinhub.Controller()
    with pytest.raises(twinhub.InputError, match="Measurement"):
        controller.step(0, {}, twinhub.RiderIntent())
    with pytest.raises(twinhub.InputError, match="stamps"):
        controller.step(-1, twinhub.Measurement(), twinhub.RiderIntent())
    with pytest.raises(twinhub.InputError, match="numbers"):
        controller.step(0, twinhub.Measurement(roll=twinhub.RollSample(0, "right")), twinhub.RiderIntent())


def test_a_law_of_ones_own_rides_within_the_limits():
    seen = []

    def law(estimate, dt_s):
        seen.append((estimate.speed_m_s, dt_s))
        return 1000.0

    ride = twinhub.ride(set={"duration_s": 4.0, "law.limits.torque_max_nm": 15.0}, law=law)
    assert len(seen) == 4001 or len(seen) == 4000
    front = ride["/control/output"]["command.front_brake_nm"]
    assert 14.0 < front.max() <= 15.0
    assert ride["/control/output"]["demand_nm"].max() == 1000.0


def test_a_rider_of_ones_own_rides():
    rider = lambda p, dt_s: -12.0 * p.roll_rad - 2.0 * p.roll_rate_rad_s  # noqa: E731
    ride = twinhub.ride(set={"duration_s": 2.0}, rider=rider)
    truth, state = ride["/plant/truth"], ride["/rider/state"]
    expected = -12.0 * truth["roll_rad"] - 2.0 * truth["roll_rate_rad_s"]
    assert np.array_equal(state["steer_torque_nm"], expected)
    assert state["pedal_force_n"].max() > 0.0


@pytest.mark.parametrize("what", ["law", "rider"])
def test_what_a_callable_raises_ends_the_ride(what):
    def broken(x, dt_s):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        twinhub.ride(set={"duration_s": 2.0}, **{what: broken})
    with pytest.raises(twinhub.InputError, match="accepted"):
        twinhub.ride(set={"duration_s": 2.0}, **{what: lambda x, dt_s: "hard"})
    with pytest.raises(twinhub.InputError, match="no_such"):
        twinhub.ride(set={"duration_s": 2.0}, **{what: "no_such"})
