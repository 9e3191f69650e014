//! How riders are used to what they ride.
//!
//! What: somebody who rides with a controller every day has gains for it. At each speed they are the
//! ones that leave the largest margin of growth under the pairs that the controller settles at, and
//! under its device on the handlebar (`twinhub_plant::rider::design`). One and the same gains have to
//! do for its quiet and its busy level.
//!
//! Assumes and ignores: riders get used to the settled pair, not to ramps and fades.

use crate::population::{Class, Person};
use crate::spec::Contestant;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};
use twinhub_control::law::Mechanism as _;
use twinhub_plant::multibody::Multibody;
use twinhub_plant::rider::closed_loop::ClosedLoop;
use twinhub_plant::rider::design::{Goal, Hands, Situation, design};
use twinhub_plant::rider::{LateralBicycle, Limb, LinearChannel, Signals};

/// Speeds of the gain tables, m/s.
const SPEEDS_M_S: [f64; 11] = [3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0];

type Slot = Arc<OnceLock<Result<Hands, String>>>;

/// Gains by class, delay and controller, found when they are needed.
pub struct Practice {
    model: Multibody,
    /// What each controller asks of a rider, and the number of that.
    kinds: Vec<Vec<Situation>>,
    kind_of: Vec<usize>,
    found: Mutex<HashMap<(Class, usize, usize), Slot>>,
    /// The bicycle alone at the speeds of the gain tables.
    alone: Vec<LateralBicycle>,
}

impl Practice {
    /// For these controllers on this bicycle. The first is what people ride today.
    ///
    /// # Errors
    /// If the bicycle has no steady state at one of the speeds.
    pub fn new(model: Multibody, contestants: &[Contestant]) -> Result<Self, String> {
        let mut kinds: Vec<Vec<Situation>> = Vec::new();
        let mut kind_of = Vec::new();
        for contestant in contestants {
            let asked: Vec<Situation> = SPEEDS_M_S
                .iter()
                .map(|v| situation(contestant, *v))
                .collect();
            let known = kinds.iter().position(|kind| *kind == asked);
            kind_of.push(known.unwrap_or(kinds.len()));
            if known.is_none() {
                kinds.push(asked);
            }
        }
        let alone: Result<Vec<_>, _> = SPEEDS_M_S
            .iter()
            .map(|v| LateralBicycle::new(&model, *v, 0.0))
            .collect();
        Ok(Self {
            kinds,
            kind_of,
            found: Mutex::default(),
            alone: alone.map_err(|e| e.to_string())?,
            model,
        })
    }

    /// The best hands of `class` with its delay number `delay` for controller number `contestant`.
    ///
    /// # Errors
    /// If the class has no designed rider, or the bicycle no steady state under the pair.
    pub fn hands(&self, class: Class, delay: usize, contestant: usize) -> Result<Hands, String> {
        let kind = self.kind_of[contestant];
        let slot = {
            let mut found = match self.found.lock() {
                Ok(found) => found,
                Err(poisoned) => poisoned.into_inner(),
            };
            found.entry((class, delay, kind)).or_default().clone()
        };
        slot.get_or_init(|| {
            let hands = class
                .hands(class.delays_s()[delay])
                .ok_or_else(|| format!("class `{}` rides as printed", class.name()))?;
            let goal = Goal {
                hands,
                at: self.kinds[kind].clone(),
            };
            Ok(design(&self.model, &goal).map_err(|e| e.to_string())?.hands)
        })
        .clone()
    }

    /// How fast the bicycle falls under `hands` without a stabilizer, at worst between these
    /// speeds, 1/s.
    pub fn growth_alone_per_s(&self, hands: &Hands, from_m_s: f64, to_m_s: f64) -> f64 {
        let (low, high) = (from_m_s.min(to_m_s) - 0.5, from_m_s.max(to_m_s) + 0.5);
        SPEEDS_M_S
            .iter()
            .zip(&self.alone)
            .filter(|(v, _)| (low..=high).contains(*v))
            .map(|(v, bicycle)| {
                ClosedLoop::new(bicycle, &[hands.linear(*v)]).growth_of_finite_per_s()
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Rider file of a person for controller number `contestant`.
    ///
    /// # Errors
    /// As [`hands`](Self::hands).
    pub fn hands_of(&self, person: &Person, contestant: usize) -> Result<Hands, String> {
        let best = self.hands(person.class, person.delay, contestant)?;
        Ok(person.with_factors(&best))
    }
}

/// What `contestant` asks of a rider at `speed_m_s`.
fn situation(contestant: &Contestant, speed_m_s: f64) -> Situation {
    let (law, limits) = (&contestant.law.law, &contestant.law.limits);
    let acts = f64::from(limits.speed_min_m_s) <= speed_m_s
        && speed_m_s <= f64::from(limits.speed_max_m_s);
    let most_nm = if acts {
        f64::from(limits.torque_max_nm)
    } else {
        0.0
    };
    let mut pairs_nm: Vec<f64> = law
        .settled_nm(speed_m_s as f32)
        .map(|nm| f64::from(nm).min(most_nm))
        .to_vec();
    pairs_nm.dedup();
    let device = twinhub_sim::device(law).map(|device| {
        let (stiffness_nm_rad, roll_rate_nms_rad) = device.linear(speed_m_s);
        LinearChannel {
            limb: Limb::Bar,
            lag: None,
            delay_s: 0.0,
            delayed: Signals {
                roll_rate: -roll_rate_nms_rad,
                ..Signals::default()
            },
            stiffness_nm_rad,
            damping_nm_s_rad: 0.0,
        }
    });
    Situation {
        speed_m_s,
        pairs_nm,
        device,
    }
}
