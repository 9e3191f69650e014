//! What can be hidden: names, parameters, the equation each belongs to.
//!
//! An effect's size counts from "absent": a gain of 1.08 has size 0.08.

use crate::course::Motors;
use crate::truth::{Patch, Truth};

/// Which rides show an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Any ride.
    Any,
    /// Hands on the bar.
    Hands,
    /// Measured motor torques, predicted speed.
    Motors,
}

/// One effect.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Name of the mechanism, or of what no library has.
    pub name: &'static str,
    /// Its main parameter, in the words of the study's answer; empty outside the library.
    pub parameter: &'static str,
    /// Value of the parameter where the effect is absent.
    pub absent: f64,
    /// Equation that it belongs to, in the answer's words.
    pub equation: &'static str,
    pub needs: Needs,
    /// A size that matters to a bicycle: what is hidden where no detection limit is known.
    pub usual_size: f64,
    /// Largest size at which the bicycle can be ridden and the equations hold.
    pub largest_size: f64,
    /// Sizes of either sign make sense.
    pub signed: bool,
    set: fn(&mut Truth, f64),
}

/// Names are unique.
impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Effect {
    /// Hides the effect with this size.
    pub fn hide(&self, truth: &mut Truth, size: f64) {
        (self.set)(truth, size);
    }

    /// The parameter's value at this size.
    pub fn value(&self, size: f64) -> f64 {
        self.absent + size
    }

    /// The motors that it takes, `given` where any will do.
    pub fn motors(&self, given: Motors) -> Motors {
        match (self.needs, given) {
            (Needs::Motors, Motors::Prescribed) => Motors::Independent,
            _ => given,
        }
    }

    /// The effect of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        LIBRARY
            .iter()
            .chain(OUTSIDE)
            .chain(BEYOND_TOLERANCE)
            .find(|e| e.name == name)
    }
}

macro_rules! effects {
    ($(#[$doc:meta])* $list:ident: $($name:literal $parameter:literal $absent:literal, $equation:literal $needs:ident,
        $usual:literal to $largest:literal $signed:literal, |$truth:ident, $size:ident| $set:expr;)*) => {
        $(#[$doc])*
        pub const $list: &[Effect] = &[$(Effect {
            name: $name,
            parameter: $parameter,
            absent: $absent,
            equation: $equation,
            needs: Needs::$needs,
            usual_size: $usual,
            largest_size: $largest,
            signed: $signed,
            set: |$truth, $size| $set,
        }),*];
    };
}

effects! {
    /// Effects that a library of mechanisms should know.
    LIBRARY:
    "tyre_relaxation" "length_m" 0.0, "steer" Any, 0.15 to 0.8 false, |t, s| t.relaxation_m = s;
    "cornering_stiffness" "compliance_rad_n" 0.0, "steer" Any, 6e-5 to 6e-4 false, |t, s| t.compliance_rad_n = s;
    "twisting_torque" "nm_rad" 0.0, "steer" Any, 4.0 to 30.0 true, |t, s| t.twisting_nm_rad = s;
    "friction_drop" "mu" 1.0, "lateral" Any, -0.95 to 0.0 false, |t, s| t.patch = Some(Patch { mu: 1.0 + s, at_m: 60.0, length_m: 0.5 });
    "cross_slope" "rad" 0.0, "roll" Any, 0.015 to 0.08 true, |t, s| t.cross_slope_rad = s;
    "crosswind" "m_s" 0.0, "roll" Any, 4.0 to 12.0 true, |t, s| t.wind_m_s = s;
    "gust" "" 0.0, "roll" Any, 12.0 to 60.0 false, |t, s| t.gust_n = s;
    "lateral_offset" "kg_m" 0.0, "roll" Any, 0.8 to 6.0 true, |t, s| t.offset_kg_m = s;
    "payload" "mass_kg" 0.0, "roll" Any, 15.0 to 60.0 false, |t, s| t.payload.mass_kg = s;
    "steer_coulomb_friction" "torque_nm" 0.0, "steer" Any, 0.4 to 2.0 false, |t, s| t.coulomb_nm = s;
    "steer_damping" "nms_rad" 0.0, "steer" Any, 0.8 to 8.0 false, |t, s| t.steer_damping_nms_rad = s;
    "headset_backlash" "gap_rad" 0.0, "steer" Any, 0.015 to 0.06 false, |t, s| t.backlash_rad = s;
    "arm_stiffness" "nm_rad" 0.0, "steer" Hands, 8.0 to 60.0 false, |t, s| t.arm_stiffness_nm_rad = s;
    "arm_damping" "nms_rad" 0.0, "steer" Hands, 1.2 to 10.0 false, |t, s| t.arm_damping_nms_rad = s;
    "arm_inertia" "kg_m2" 0.0, "steer" Hands, 0.12 to 0.5 false, |t, s| t.arm_inertia_kg_m2 = s;
    "pedalling_torque" "amplitude_nm" 0.0, "roll" Any, 4.0 to 25.0 false, |t, s| t.pedal_nm = s;
    "upper_body_lean" "" 0.0, "roll" Any, 35.0 to 45.0 false, |t, s| t.upper_body_kg = s;
    "wheel_imbalance" "nm_s2" 0.0, "steer" Any, 0.002 to 0.02 false, |t, s| t.imbalance_nm_s2 = s;
    "roll_sensor_bias" "rad" 0.0, "sensor:roll_rad" Any, 0.03 to 0.2 true, |t, s| t.sensors.roll_bias_rad = s;
    "steer_sensor_bias" "rad" 0.0, "sensor:steer_rad" Any, 0.03 to 0.2 true, |t, s| t.sensors.steer_bias_rad = s;
    "steer_sensor_scale" "gain" 1.0, "sensor:steer_rad" Any, 0.08 to 0.5 true, |t, s| t.sensors.steer_scale = 1.0 + s;
    "steer_sensor_delay" "s" 0.0, "sensor:steer_rad" Any, 0.02 to 0.15 false, |t, s| t.sensors.steer_delay_s = s;
    "roll_rate_sensor_delay" "s" 0.0, "sensor:roll_rate_rad_s" Any, 0.02 to 0.15 false, |t, s| t.sensors.roll_rate_delay_s = s;
    "gyro_misalignment" "rad" 0.0, "sensor:roll_rate_rad_s" Any, 0.05 to 0.4 true, |t, s| t.sensors.gyro_rotation_rad = s;
    "speed_scale" "gain" 1.0, "sensor:speed_m_s" Any, 0.06 to 0.3 true, |t, s| t.sensors.speed_scale = 1.0 + s;
    "steer_torque_gain" "gain" 1.0, "steer" Any, 0.12 to 0.6 true, |t, s| t.sensors.torque_gain = 1.0 + s;
    "lateral_force_gain" "gain" 1.0, "roll" Any, 0.12 to 0.6 true, |t, s| t.sensors.force_gain = 1.0 + s;
    "front_motor_gain" "gain" 1.0, "longitudinal" Motors, 0.1 to 0.6 true, |t, s| t.front_gain = 1.0 + s;
    "rear_motor_gain" "gain" 1.0, "longitudinal" Motors, 0.1 to 0.6 true, |t, s| t.rear_gain = 1.0 + s;
    "front_motor_lag" "time_constant_s" 0.0, "longitudinal" Motors, 0.08 to 0.6 false, |t, s| t.front_lag_s = s;
    "rear_motor_lag" "time_constant_s" 0.0, "longitudinal" Motors, 0.08 to 0.6 false, |t, s| t.rear_lag_s = s;
    "motor_saturation" "" 0.0, "longitudinal" Motors, 8.0 to 11.5 false, |t, s| t.saturation_nm = 12.0 - s;
    "rolling_resistance" "n" 0.0, "longitudinal" Motors, 5.0 to 60.0 false, |t, s| t.rolling_n = s;
    "brake_drag" "n" 0.0, "longitudinal" Motors, 5.0 to 60.0 false, |t, s| t.brake_drag_n = s;
    "aerodynamic_drag" "" 0.0, "longitudinal" Motors, 0.35 to 1.5 false, |t, s| t.drag_kg_m = s;
    "longitudinal_slope" "rad" 0.0, "longitudinal" Motors, 0.008 to 0.06 true, |t, s| t.slope_rad = s;
}

effects! {
    /// Effects that no library has.
    OUTSIDE:
    "cubic_steer_stiffness" "" 0.0, "steer" Any, 500.0 to 6000.0 false, |t, s| t.outside.cubic_nm_rad3 = s;
    "damper_with_memory" "" 0.0, "steer" Any, 12.0 to 80.0 false, |t, s| t.outside.maxwell_nm_rad = s;
    "steer_hysteresis" "" 0.0, "steer" Any, 0.9 to 3.0 false, |t, s| t.outside.hysteresis_nm = s;
    "torque_by_speed" "" 0.0, "steer" Any, 0.5 to 2.5 false, |t, s| t.outside.speed_torque_nm = s;
    "sloshing_tank" "" 0.0, "roll" Any, 12.0 to 25.0 false, |t, s| t.outside.slosh_kg = s;
    "fork_torsion" "" 0.0, "steer" Any, -5.0 to 0.0 false, |t, s| t.outside.fork_hz = 12.0 + s;
}

/// Effects that are the same force in rides that all go one way: only their names differ there.
pub const SAME_ONE_WAY: &[&[&str]] = &[
    &["rolling_resistance", "brake_drag", "longitudinal_slope"],
    &["lateral_offset", "cross_slope"],
];

/// Whether two effects are the same force in rides that all go one way.
pub fn same_one_way(a: &str, b: &str) -> bool {
    a == b
        || SAME_ONE_WAY
            .iter()
            .any(|g| g.contains(&a) && g.contains(&b))
}

effects! {
    /// Parameters of the bicycle far beyond their declared tolerance.
    BEYOND_TOLERANCE:
    "IHzz" "IHzz" 0.00708, "steer" Any, 0.04 to 0.2 false, |t, s| t.bicycle.IHzz += s;
}

/// Pairs that a plain study cannot tell apart, how that study is laid out, and what parts them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub names: [&'static str; 2],
    pub separate: Separate,
}

/// Experiments that part a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separate {
    OutAndBack,
    IndependentMotors,
    SpeedLadder,
    TwoAmplitudes,
    HandsOff,
}

pub const PAIRS: &[Pair] = &[
    Pair {
        names: ["lateral_offset", "cross_slope"],
        separate: Separate::OutAndBack,
    },
    Pair {
        names: ["front_motor_lag", "rear_motor_lag"],
        separate: Separate::IndependentMotors,
    },
    Pair {
        names: ["rolling_resistance", "aerodynamic_drag"],
        separate: Separate::SpeedLadder,
    },
    Pair {
        names: ["steer_coulomb_friction", "steer_damping"],
        separate: Separate::TwoAmplitudes,
    },
    Pair {
        names: ["arm_damping", "steer_damping"],
        separate: Separate::HandsOff,
    },
    Pair {
        names: ["crosswind", "lateral_offset"],
        separate: Separate::OutAndBack,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::Bicycle;

    #[test]
    fn every_effect_changes_the_truth_and_names_are_unique() {
        let clean = Truth::clean(Bicycle::benchmark());
        let all: Vec<&Effect> = LIBRARY.iter().chain(OUTSIDE).collect();
        for (k, effect) in all.iter().enumerate() {
            let mut truth = clean.clone();
            effect.hide(&mut truth, effect.usual_size);
            assert_ne!(truth, clean, "{}", effect.name);
            assert!(effect.usual_size <= effect.largest_size, "{}", effect.name);
            assert!(
                all[..k].iter().all(|e| e.name != effect.name),
                "{}",
                effect.name
            );
        }
        for pair in PAIRS {
            assert!(pair.names.iter().all(|n| Effect::named(n).is_some()));
        }
    }
}
