//! What MuJoCo's callback needs to know of our tyres, as plain numbers.

use twinhub_plant::multibody::Parameters;
use twinhub_plant::tyre::{Combined, Friction, LateralForm, Tyre};

/// Rear and front tyre in the order of `mujoco_peer.c`; refuses options that it does not have.
pub fn tyres(p: &Parameters) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::new();
    for (tyre, wheel) in [
        (&p.tyre.rear, &p.rear_wheel),
        (&p.tyre.front, &p.front_wheel),
    ] {
        let Tyre::MagicFormula(t) = tyre else {
            return Err("the callback has the Magic Formula of 2017 only".to_owned());
        };
        let plain = t.friction == Friction::AsFile
            && t.combined == Combined::None
            && t.lateral_form == LateralForm::Motorcycle
            && t.frozen_load_n.is_none()
            && t.load_range_n.is_none()
            && t.relaxation_length_m.is_none();
        if !plain {
            return Err("the callback has none of the tyre's options".to_owned());
        }
        numbers.extend([
            t.nominal_load_n,
            t.longitudinal_shape_ratio,
            t.longitudinal_friction_ratio,
            t.longitudinal_stiffness_ratio * t.longitudinal_gain,
            t.slip_shape_ratio,
            t.camber_shape_ratio,
            t.lateral_friction_ratio,
            t.lateral_friction_load_ratio,
            t.cornering_max_per_rad * t.cornering_gain,
            t.cornering_peak_ratio,
            t.camber_stiffness_per_rad * t.camber_gain,
            t.camber_stiffness_load_per_rad * t.camber_gain,
            t.trail_slope_per_rad,
            t.trail_slope_load_per_rad,
            t.trail_shape_ratio,
            t.trail_peak_ratio * t.trail_gain,
            t.trail_peak_load_ratio * t.trail_gain,
            t.twisting_per_rad * t.twisting_gain,
            t.twisting_load_per_rad * t.twisting_gain,
            t.rolling_resistance_ratio,
            t.overturning_ratio * t.overturning_gain,
            t.vertical.stiffness_n_m,
            t.vertical.damping_n_s_m,
            wheel.radius_m,
            p.tyre.slip_speed_floor_m_s,
        ]);
    }
    Ok(numbers)
}
