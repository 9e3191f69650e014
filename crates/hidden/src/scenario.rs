//! What is hidden in a set, from kind and seed alone.

use crate::bicycle::Bicycle;
use crate::course::{Course, Hands, Layout, Motors};
use crate::effect::{Effect, LIBRARY, Needs, OUTSIDE, PAIRS, Pair, Separate};
use crate::random::Stream;
use crate::ride::{Fell, SAMPLE_S, Track, ride};
use crate::truth::Truth;

/// Standard deviation of every parameter that studies declare.
pub const DECLARED_RATIO: f64 = 0.02;
/// Time by which inputs are late in a shifted set.
pub const SHIFT_S: f64 = 10.0;
/// How often a ride that fell is tried again, with 0.7 of the effect.
const TRIES: usize = 8;

/// Families of sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Parameters spread as declared, nothing else.
    Clean,
    /// One effect that a library should know.
    OneEffect,
    TwoEffects,
    /// One effect that no library has.
    Outside,
    /// Parameters spread twice as far as declared.
    Mismatched,
    /// Inputs late against outputs.
    Shifted,
    /// Rides of two bicycles, mixed.
    Mixed,
    /// One of a pair that the rides cannot tell apart.
    Confounded,
}

impl Kind {
    pub const ALL: [Self; 8] = [
        Self::Clean,
        Self::OneEffect,
        Self::TwoEffects,
        Self::Outside,
        Self::Mismatched,
        Self::Shifted,
        Self::Mixed,
        Self::Confounded,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::OneEffect => "one_effect",
            Self::TwoEffects => "two_effects",
            Self::Outside => "outside",
            Self::Mismatched => "mismatched",
            Self::Shifted => "shifted",
            Self::Mixed => "mixed",
            Self::Confounded => "confounded",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }
}

/// One hidden effect and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hidden {
    pub effect: &'static Effect,
    pub size: f64,
}

/// A set before it is ridden.
#[derive(Clone, Debug)]
pub struct Scenario {
    pub kind: Kind,
    pub seed: u64,
    pub hidden: Vec<Hidden>,
    pub pair: Option<&'static Pair>,
    pub layout: Layout,
    pub spread_ratio: f64,
    /// Whether the study declares the sensors' noise.
    pub declares_noise: bool,
    rider_delay: usize,
}

/// A set, ridden.
#[derive(Clone, Debug)]
pub struct Ridden {
    pub courses: Vec<Course>,
    pub tracks: Vec<Track>,
    pub truths: Vec<Truth>,
    /// As ridden: smaller than asked for where the bicycle fell.
    pub hidden: Vec<Hidden>,
}

impl Scenario {
    /// The scenario of this kind and seed, its effects at their usual sizes.
    pub fn new(kind: Kind, seed: u64) -> Self {
        let mut pick = Stream::new(seed, kind.name());
        let pair = (kind == Kind::Confounded).then(|| &PAIRS[pick.index(PAIRS.len())]);
        let effects: Vec<&'static Effect> = match kind {
            Kind::OneEffect => vec![&LIBRARY[pick.index(LIBRARY.len())]],
            Kind::TwoEffects => two(&mut pick),
            Kind::Outside => vec![&OUTSIDE[pick.index(OUTSIDE.len())]],
            Kind::Confounded => {
                let names = pair.map_or([""; 2], |p| p.names);
                Effect::named(names[pick.index(2)]).into_iter().collect()
            }
            Kind::Clean | Kind::Mismatched | Kind::Shifted | Kind::Mixed => vec![],
        };
        Self::with_effects(kind, seed, &effects, pair, &mut pick)
    }

    /// A set with this one effect.
    pub fn of_effect(effect: &'static Effect, seed: u64) -> Self {
        let kind = match OUTSIDE.iter().any(|e| e.name == effect.name) {
            true => Kind::Outside,
            false => Kind::OneEffect,
        };
        Self::with_effects(
            kind,
            seed,
            &[effect],
            None,
            &mut Stream::new(seed, effect.name),
        )
    }

    fn with_effects(
        kind: Kind,
        seed: u64,
        effects: &[&'static Effect],
        pair: Option<&'static Pair>,
        pick: &mut Stream,
    ) -> Self {
        let any = match pick.uniform() < 0.5 {
            true => Motors::Prescribed,
            false => Motors::Independent,
        };
        let motors = effects.iter().fold(any, |m, e| e.motors(m));
        let mut layout = Layout::standard(motors);
        if let Some(pair) = pair {
            plain(&mut layout, pair.separate);
        }
        let hidden = effects.iter().map(|effect| {
            let sign = if effect.signed { pick.sign() } else { 1.0 };
            Hidden {
                effect,
                size: sign * effect.usual_size,
            }
        });
        let hidden = hidden.collect();
        Self {
            kind,
            seed,
            hidden,
            pair,
            layout,
            spread_ratio: match kind {
                Kind::Mismatched => 2.0 * DECLARED_RATIO,
                _ => DECLARED_RATIO,
            },
            declares_noise: pick.uniform() < 0.5,
            rider_delay: 2 + pick.index(3),
        }
    }

    /// The same bicycle, rider and courses with nothing hidden.
    pub fn clean_twin(&self) -> Self {
        Self {
            hidden: vec![],
            ..self.clone()
        }
    }

    /// The effects in these sizes, which count from "absent" and keep the sign that the seed gave.
    pub fn sized(&self, sizes: &[f64]) -> Self {
        let mut found = self.clone();
        for (hidden, size) in found.hidden.iter_mut().zip(sizes) {
            let most = hidden
                .effect
                .largest_size
                .abs()
                .max(hidden.effect.usual_size.abs());
            hidden.size = hidden.size.signum() * size.abs().min(most);
        }
        found
    }

    /// The experiment that parts the pair, with the same bicycle and the same thing hidden.
    pub fn separated(&self, separate: Separate) -> Self {
        let mut found = self.clone();
        let layout = &mut found.layout;
        match separate {
            Separate::OutAndBack => layout.out_and_back = true,
            Separate::IndependentMotors => layout.motors = Motors::Independent,
            Separate::SpeedLadder => {
                layout.one_speed = false;
                if layout.motors == Motors::Independent {
                    layout.motors = Motors::CoastDown;
                }
            }
            Separate::TwoAmplitudes => layout.two_amplitudes = true,
            Separate::HandsOff => layout.hands = Hands::Mixed,
        }
        found
    }

    /// Rides it. If the bicycle falls, less is hidden.
    pub fn ride(&self) -> Result<Ridden, Fell> {
        let mut scenario = self.clone();
        for _ in 1..TRIES {
            match scenario.ride_once() {
                Ok(ridden) => return Ok(ridden),
                Err(_) => scenario.hidden.iter_mut().for_each(|h| h.size *= 0.7),
            }
        }
        scenario.ride_once()
    }

    fn ride_once(&self) -> Result<Ridden, Fell> {
        let mut draw = Stream::new(self.seed, "bicycle");
        let bicycle = Bicycle::benchmark().spread(self.spread_ratio, &mut draw);
        let mut truth = Truth::clean(bicycle);
        for hidden in &self.hidden {
            hidden.effect.hide(&mut truth, hidden.size);
        }
        let courses = self.layout.courses(&mut Stream::new(self.seed, "courses"));
        let mut truths = vec![];
        let mut tracks = vec![];
        for (k, course) in courses.iter().enumerate() {
            let mut truth = truth.clone();
            // Every second ride is the other bicycle's.
            if self.kind == Kind::Mixed && k % 2 == 1 {
                truth.bicycle = truth.bicycle.another();
            }
            tracks.push(ride(&truth, course, self.seed, self.rider_delay)?);
            truths.push(truth);
        }
        Ok(Ridden {
            courses,
            tracks,
            truths,
            hidden: self.hidden.clone(),
        })
    }
}

/// Two effects that do not stand in each other's equation for the same thing.
fn two(pick: &mut Stream) -> Vec<&'static Effect> {
    loop {
        let (a, b) = (
            &LIBRARY[pick.index(LIBRARY.len())],
            &LIBRARY[pick.index(LIBRARY.len())],
        );
        let pair = PAIRS
            .iter()
            .any(|p| p.names.contains(&a.name) && p.names.contains(&b.name));
        if a.name != b.name && a.equation != b.equation && !pair {
            return vec![a, b];
        }
    }
}

/// The layout in which a pair cannot be told apart.
fn plain(layout: &mut Layout, separate: Separate) {
    match separate {
        Separate::OutAndBack | Separate::TwoAmplitudes => {}
        Separate::IndependentMotors => layout.motors = Motors::Common,
        Separate::SpeedLadder => layout.one_speed = true,
        Separate::HandsOff => layout.hands = Hands::On,
    }
}

/// Band of a torque: frequencies below which a tenth and nine tenths of its power lie.
pub fn band_hz(track: &Track, axis: usize) -> Option<[f64; 2]> {
    let every = libm::round(SAMPLE_S / track.step_s) as usize;
    let torque: Vec<f64> = track
        .moments
        .iter()
        .step_by(every)
        .map(|m| m.outside_nm[axis])
        .collect();
    let mean = torque.iter().sum::<f64>() / torque.len() as f64;
    let step_hz = 0.1;
    let mut power = vec![];
    for k in 0..200 {
        let hz = step_hz * (k as f64 + 0.5);
        let turn = 2.0 * core::f64::consts::PI * hz * SAMPLE_S;
        // Goertzel's recurrence.
        let (mut s1, mut s2) = (0.0, 0.0);
        let factor = 2.0 * libm::cos(turn);
        for (n, x) in torque.iter().enumerate() {
            let window =
                0.5 - 0.5 * libm::cos(2.0 * core::f64::consts::PI * n as f64 / torque.len() as f64);
            let s = window * (x - mean) + factor * s1 - s2;
            s2 = s1;
            s1 = s;
        }
        power.push(s1 * s1 + s2 * s2 - factor * s1 * s2);
    }
    let total: f64 = power.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let below = |part: f64| {
        let mut sum = 0.0;
        let k = power.iter().position(|p| {
            sum += p;
            sum >= part * total
        });
        step_hz * (k.unwrap_or(0) as f64 + 0.5)
    };
    Some([below(0.1), below(0.9)])
}

impl Needs {
    /// Whether a layout shows it at all.
    pub fn met_by(self, layout: &Layout) -> bool {
        match self {
            Self::Any => true,
            Self::Hands => layout.hands != Hands::Off,
            Self::Motors => layout.motors != Motors::Prescribed,
        }
    }
}
