//! Probes: nameless terms in each equation. Where no mechanism explains what is left, the probe that
//! does says in which equation it lies and with what it goes; a probe is never a cause.

use twinhub_mechanism::{Card, Equation, Family, Mechanism, Moment, Param, Wrench};

/// What a probe multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regressor {
    Roll,
    Steer,
    RollRate,
    SteerRate,
    RollAccel,
    SteerAccel,
    SteerSquareSpeed,
    SteerRateSpeed,
    RollSpeed,
    SteerCubed,
    SteerRateSquared,
    RollCubed,
    RollRateSquared,
    SteerRateSign,
    SteerTorque,
    SteerTorqueSquared,
    Speed,
    SpeedSquared,
    Traction,
    Brake,
    Constant,
    TurnSquared,
}

impl Regressor {
    fn at(self, m: &Moment<'_>) -> f64 {
        let [roll, steer] = m.angle_rad;
        let [roll_rate, steer_rate] = m.rate_rad_s;
        let v = m.speed_m_s;
        match self {
            Self::Roll => roll,
            Self::Steer => steer,
            Self::RollRate => roll_rate,
            Self::SteerRate => steer_rate,
            Self::RollAccel => m.accel_rad_s2[0],
            Self::SteerAccel => m.accel_rad_s2[1],
            Self::SteerSquareSpeed => v * v * steer,
            Self::SteerRateSpeed => v * steer_rate,
            Self::RollSpeed => v * roll,
            Self::SteerCubed => steer * steer * steer * 100.0,
            Self::SteerRateSquared => steer_rate * steer_rate.abs(),
            Self::RollCubed => roll * roll * roll * 100.0,
            Self::RollRateSquared => roll_rate * roll_rate.abs(),
            Self::SteerRateSign => libm::tanh(steer_rate / 0.05),
            Self::SteerTorque => m.inputs.steer_torque_nm,
            Self::SteerTorqueSquared => m.inputs.steer_torque_nm * m.inputs.steer_torque_nm.abs(),
            Self::Speed => v,
            Self::SpeedSquared => v * v,
            Self::Traction => m.inputs.rear_traction_nm,
            Self::Brake => m.inputs.front_brake_nm,
            Self::Constant => 1.0,
            Self::TurnSquared => {
                let yaw = m.yaw_rate_rad_s();
                v * yaw * v * yaw
            }
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Roll => "roll",
            Self::Steer => "steer",
            Self::RollRate => "roll rate",
            Self::SteerRate => "steer rate",
            Self::RollAccel => "roll acceleration",
            Self::SteerAccel => "steer acceleration",
            Self::SteerSquareSpeed => "speed² steer",
            Self::SteerRateSpeed => "speed times steer rate",
            Self::RollSpeed => "speed times roll",
            Self::SteerCubed => "steer³",
            Self::SteerRateSquared => "steer rate squared",
            Self::RollCubed => "roll³",
            Self::RollRateSquared => "roll rate squared",
            Self::SteerRateSign => "the sign of the steer rate",
            Self::SteerTorque => "steer torque",
            Self::SteerTorqueSquared => "steer torque squared",
            Self::Speed => "speed",
            Self::SpeedSquared => "speed squared",
            Self::Traction => "rear traction",
            Self::Brake => "front brake",
            Self::Constant => "nothing: constant",
            Self::TurnSquared => "lateral acceleration squared",
        }
    }
}

/// A term `size` times a regressor in one equation.
#[derive(Debug)]
pub struct Probe {
    card: Card,
    pub equation: Equation,
    pub regressor: Regressor,
}

static PARAM: [Param; 1] = [Param {
    name: "size",
    null: 0.0,
    least: f64::NEG_INFINITY,
    most: f64::INFINITY,
    probe: 0.1,
    starts: &[],
    about: "size of the term",
}];

const fn probe(equation: Equation, regressor: Regressor) -> Probe {
    Probe {
        card: Card {
            name: "latent_force",
            family: Family::Environment,
            equations: match equation {
                Equation::Roll => &[Equation::Roll],
                Equation::Steer => &[Equation::Steer],
                _ => &[Equation::Longitudinal],
            },
            claim: "something that has no name here",
            equation: "a term in one equation",
            source: "own",
            parameters: &PARAM,
            requires: &[],
            confounded_with: &[],
            separated_by: "",
        },
        equation,
        regressor,
    }
}

macro_rules! probes {
    ($($equation:ident: $($regressor:ident),*;)*) => {
        /// All probes.
        pub static PROBES: &[&Probe] = &[
            $($({ static P: Probe = probe(Equation::$equation, Regressor::$regressor); &P }),*),*
        ];
    };
}

probes! {
    Roll: Roll, Steer, RollRate, SteerRate, RollAccel, SteerAccel, SteerSquareSpeed, SteerRateSpeed,
        RollSpeed, SteerCubed, RollCubed, RollRateSquared, SteerTorque, Constant, TurnSquared;
    Steer: Roll, Steer, RollRate, SteerRate, RollAccel, SteerAccel, SteerSquareSpeed, SteerRateSpeed,
        RollSpeed, SteerCubed, SteerRateSquared, SteerRateSign, SteerTorque, SteerTorqueSquared,
        Constant;
    Longitudinal: Constant, Speed, SpeedSquared, Traction, Brake, TurnSquared;
}

impl Mechanism for Probe {
    fn card(&self) -> &'static Card {
        // Probes live in statics; the list hands out the reference that is needed here.
        PROBES
            .iter()
            .find(|p| std::ptr::eq(**p, self))
            .map_or(&PROBES[0].card, |p| &p.card)
    }

    fn pushes(&self) -> bool {
        true
    }

    fn feeds_back(&self) -> bool {
        self.equation != Equation::Longitudinal
    }

    fn wrench(&self, p: &[f64], at: &Moment<'_>, _memory: &[f64]) -> Wrench {
        let value = p[0] * self.regressor.at(at);
        let mut wrench = Wrench::default();
        match self.equation {
            Equation::Roll => wrench.roll_nm = value,
            Equation::Steer => wrench.steer_nm = value,
            _ => wrench.force_n = value,
        }
        wrench
    }
}
