//! What: noise levels and calibration parameters of the baseline, on the fit rides.
//!
//! Equation: levels by scoring on the likelihood of the innovations; calibration parameters z (in
//! declared standard deviations) by Gauss-Newton on sum e²/s + z², within a box.
//!
//! Source: Harvey (1989), section 3.4.5; the box after the finding that free calibration eats
//! causes, see `thresholds.toml`.
//!
//! Assumes and ignores: levels shared by all rides.
//!
//! Valid for: some hundred readings a level.
//!
//! Checked by: `tests` of the search on simulated rides.

use super::thresholds::THRESHOLDS;
use crate::engine::small::{dot, solve};
use crate::engine::{FreeNoise, Model, Pass, Plant, Prepared, Ride, sensitivity};
use crate::study::{Study, Tolerance};
use std::sync::Arc;
use twinhub_linear::SYMBOLS;

/// Whitened innovations and columns, of all rides one after the other.
pub type Column = Vec<f64>;

/// The rides of one use.
#[derive(Clone, Debug)]
pub struct Rides(pub Vec<Prepared>);

/// Length of an excerpt of a ride.
const EXCERPT_S: f64 = 8.0;

impl Rides {
    /// The middle of the longest window of each ride, some seconds long: enough for a first look.
    pub fn excerpt(&self, model: &Model) -> Option<Self> {
        let plant = model.plant().ok()?;
        let cut = |prepared: &Prepared| {
            let mut ride = prepared.ride.clone();
            let longest = ride
                .windows
                .iter()
                .copied()
                .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
            let middle = 0.5 * (longest[0] + longest[1]);
            let from = longest[0].max(middle - 0.5 * EXCERPT_S);
            let to = longest[1].min(middle + 0.5 * EXCERPT_S);
            ride.windows = vec![[from, to]];
            for sensor in &mut ride.sensors {
                sensor.samples.retain(|(t, _)| *t >= from && *t < to);
            }
            Some(Prepared::new(ride, &plant))
        };
        let rides: Vec<Prepared> = self.0.iter().filter_map(cut).collect();
        let empty = rides.iter().all(|r| r.course.readings.is_empty());
        (!empty).then_some(Self(rides))
    }

    fn readings(&self) -> usize {
        self.0.iter().map(|r| r.course.readings.len()).sum()
    }
}

/// One model's passes over rides.
pub struct Passes {
    pub plant: Plant,
    pub passes: Vec<Pass>,
    pub courses: Vec<Option<crate::engine::course::Course>>,
}

impl Passes {
    /// None where the plant cannot be.
    pub fn run(rides: &Rides, model: &Model, recording: bool) -> Option<Self> {
        let plant = model.plant().ok()?;
        let (passes, courses) = rides
            .0
            .iter()
            .map(|r| r.run(&plant, model, recording))
            .unzip();
        Some(Self {
            plant,
            passes,
            courses,
        })
    }

    pub fn minus_log_likelihood(&self) -> f64 {
        self.passes.iter().map(Pass::minus_log_likelihood).sum()
    }

    pub fn course<'a>(&'a self, rides: &'a Rides, index: usize) -> &'a crate::engine::course::Course {
        self.courses[index]
            .as_ref()
            .unwrap_or(&rides.0[index].course)
    }

    /// Innovations over their standard deviations.
    pub fn whitened(&self) -> Column {
        let all = self
            .passes
            .iter()
            .flat_map(|p| p.error.iter().zip(&p.variance));
        all.map(|(e, s)| e / s.sqrt()).collect()
    }

    /// Whitened change of the innovations when the plant becomes `changed`.
    pub fn column(&self, rides: &Rides, model: &Model, changed: &Plant) -> Column {
        let mut column = vec![];
        for (index, pass) in self.passes.iter().enumerate() {
            let ride = &rides.0[index].ride;
            let course = self.course(rides, index);
            let change = sensitivity::of_pass(ride, course, &self.plant, changed, model, pass);
            column.extend(change.iter().zip(&pass.variance).map(|(e, s)| e / s.sqrt()));
        }
        column
    }

    /// Ride and time stamp of every entry of a column.
    pub fn stamps(&self, rides: &Rides) -> Vec<(usize, f64)> {
        (0..self.passes.len())
            .flat_map(|i| {
                self.course(rides, i)
                    .readings
                    .iter()
                    .map(move |r| (i, r.t_s))
            })
            .collect()
    }
}

/// Columns of the calibration parameters that matter, with their index into all, and their products.
#[derive(Debug, Default)]
pub struct Columns {
    pub list: Vec<(usize, Column)>,
    /// One column times another, by rows.
    products: Vec<f64>,
}

impl Columns {
    /// Leaves out those that move the innovations too little.
    fn new(all: Vec<Column>) -> Arc<Self> {
        let matters = |c: &Column| 0.5 * dot(c, c) > THRESHOLDS.calibration_least_nats;
        let list: Vec<(usize, Column)> = all
            .into_iter()
            .enumerate()
            .filter(|(_, c)| matters(c))
            .collect();
        let m = list.len();
        let mut products = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..=i {
                let x = dot(&list[i].1, &list[j].1);
                products[i * m + j] = x;
                products[j * m + i] = x;
            }
        }
        Arc::new(Self { list, products })
    }

    /// Of the baseline's model, after a pass over the rides.
    pub fn of(rides: &Rides, baseline: &Baseline, passes: &Passes) -> Arc<Self> {
        Self::new(calibration_columns(
            rides,
            &baseline.model,
            passes,
            &baseline.all,
            &baseline.z,
        ))
    }

    /// Product of the columns at two places of the list.
    pub fn product(&self, i: usize, j: usize) -> f64 {
        self.products[i * self.list.len() + j]
    }
}

/// One calibration parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    pub symbol: &'static str,
    pub value: f64,
    pub sd: f64,
}

/// The parameters that may be calibrated, with their declared standard deviations.
pub fn calibrated(study: &Study, bicycle: &twinhub_linear::Bicycle) -> Vec<Calibrated> {
    let free = SYMBOLS
        .iter()
        .filter(|s| !matches!(**s, "g" | "IByy" | "IHyy"));
    free.filter_map(|&symbol| {
        let value = bicycle.get(symbol)?;
        let sd = match study.tolerances.get(symbol) {
            Some(Tolerance::Ratio(r)) => r * value.abs(),
            Some(Tolerance::Absolute(a)) => *a,
            None => study.tolerance_ratio * value.abs(),
        };
        (sd > 0.0).then_some(Calibrated { symbol, value, sd })
    })
    .collect()
}

/// A model with calibration parameters z away from the declared values, or none if it cannot be.
pub fn moved(model: &Model, all: &[Calibrated], z: &[f64]) -> Option<Model> {
    let mut model = model.clone();
    for (c, z) in all.iter().zip(z) {
        model.bicycle.set(c.symbol, c.value + z * c.sd).ok()?;
    }
    Some(model)
}

/// Columns of the calibration parameters, one declared standard deviation each.
fn calibration_columns(
    rides: &Rides,
    model: &Model,
    passes: &Passes,
    all: &[Calibrated],
    z: &[f64],
) -> Vec<Column> {
    (0..all.len())
        .map(|i| {
            let step = if z[i] > 0.0 { -0.5 } else { 0.5 };
            let mut there = z.to_vec();
            there[i] += step;
            let plant = moved(model, all, &there).and_then(|m| m.plant().ok());
            match plant {
                Some(plant) => passes
                    .column(rides, model, &plant)
                    .iter()
                    .map(|x| x / step)
                    .collect(),
                None => vec![0.0; passes.passes.iter().map(|p| p.error.len()).sum()],
            }
        })
        .collect()
}

/// A calibrated model.
#[derive(Clone)]
pub struct Baseline {
    pub model: Model,
    pub all: Vec<Calibrated>,
    pub z: Vec<f64>,
    pub columns: Arc<Columns>,
    /// Log likelihood of the fit rides, prior included, with the sign turned.
    pub cost: f64,
}

/// First guess of the random torques and force that act on a bicycle: a good road and a steady rider.
pub const FIRST_PROCESS: [f64; 3] = [1.0, 0.2, 2.0];

/// First guess of the model.
pub fn start(bicycle: &twinhub_linear::Bicycle, free: &FreeNoise) -> Model {
    Model {
        bicycle: bicycle.clone(),
        active: vec![],
        levels: crate::engine::Levels {
            process: FIRST_PROCESS,
            sensors: free.range.iter().map(|r| r[0]).collect(),
        },
        latent: [None; 2],
    }
}

/// Re-estimates the noise levels, `rounds` scoring steps at most.
pub fn fit_levels(rides: &Rides, free: &FreeNoise, model: &Model, rounds: usize) -> Model {
    const DIFFERENCE: f64 = 1e-3;
    const PRIOR: f64 = 1.0 / (3.4 * 3.4);
    let longitudinal = rides.0.iter().any(|r| r.ride.speed.is_none());
    let mut model = model.clone();
    let count = 3 + free.range.len();
    let get = |m: &Model| -> Vec<f64> {
        m.levels
            .process
            .iter()
            .chain(&m.levels.sensors)
            .map(|x| libm::log(*x))
            .collect()
    };
    let set = |m: &Model, x: &[f64]| -> Model {
        let mut m = m.clone();
        for i in 0..count {
            let (least, most) = match i {
                0..3 => (1e-4, 1e3),
                _ => (free.range[i - 3][1], free.range[i - 3][2]),
            };
            let value = libm::exp(x[i]).clamp(least, most);
            if i < 3 {
                m.levels.process[i] = value;
            } else {
                m.levels.sensors[i - 3] = value;
            }
        }
        m
    };
    let used: Vec<usize> = (0..count).filter(|i| *i != 2 || longitudinal).collect();
    let origin = get(&model);
    let prior = |x: &[f64]| -> f64 {
        x.iter()
            .zip(&origin)
            .map(|(a, b)| 0.5 * PRIOR * (a - b) * (a - b))
            .sum()
    };
    let Some(mut now) = Passes::run(rides, &model, false) else {
        return model;
    };
    let mut value = now.minus_log_likelihood();
    for _ in 0..rounds {
        let x = get(&model);
        let slopes: Vec<Option<Passes>> = used
            .iter()
            .map(|i| {
                let mut there = x.clone();
                there[*i] += DIFFERENCE;
                Passes::run(rides, &set(&model, &there), false)
            })
            .collect();
        let m = used.len();
        let mut gradient = vec![0.0; m];
        let mut information = vec![0.0; m * m];
        for (ride, pass) in now.passes.iter().enumerate() {
            let there: Vec<&Pass> = slopes
                .iter()
                .map(|s| s.as_ref().map_or(pass, |s| &s.passes[ride]))
                .collect();
            let mut de = vec![0.0; m];
            let mut ds = vec![0.0; m];
            for (k, (e, s)) in pass.error.iter().zip(&pass.variance).enumerate() {
                for i in 0..m {
                    de[i] = (there[i].error[k] - e) / DIFFERENCE;
                    ds[i] = (there[i].variance[k] - s) / (DIFFERENCE * s);
                }
                for i in 0..m {
                    gradient[i] += e * de[i] / s + 0.5 * ds[i] * (1.0 - e * e / s);
                    for j in 0..=i {
                        information[i * m + j] += de[i] * de[j] / s + 0.5 * ds[i] * ds[j];
                    }
                }
            }
        }
        for i in 0..m {
            gradient[i] += PRIOR * (x[used[i]] - origin[used[i]]);
            information[i * m + i] += PRIOR;
            for j in 0..i {
                information[j * m + i] = information[i * m + j];
            }
        }
        let right: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let Some(step) = solve(&information, &[right]) else {
            break;
        };
        let before = value + prior(&x);
        let mut share = 1.0;
        let mut better = false;
        while share > 0.05 {
            let mut there = x.clone();
            for (i, k) in used.iter().enumerate() {
                there[*k] += (share * step[0][i]).clamp(-1.5, 1.5);
            }
            let trial = set(&model, &there);
            if let Some(passes) = Passes::run(rides, &trial, false) {
                let cost = passes.minus_log_likelihood();
                if cost + prior(&get(&trial)) < before {
                    (model, now, value) = (trial, passes, cost);
                    better = true;
                    break;
                }
            }
            share *= 0.3;
        }
        if !better || before - value - prior(&get(&model)) < 0.5 {
            break;
        }
    }
    model
}

/// Gauss-Newton step of parameters with a box: minimises |e + C d|² + prior, entries at the box
/// stay there. The columns are those of the calibration, then some more.
pub fn bounded_step(
    residual: &Column,
    calibration: &Columns,
    more: &[&Column],
    precision: &[f64],
    at: &[f64],
    origin: &[f64],
    least: &[f64],
    most: &[f64],
) -> Vec<f64> {
    let known = calibration.list.len();
    let columns: Vec<&Column> = (calibration.list.iter().map(|(_, c)| c))
        .chain(more.iter().copied())
        .collect();
    let m = columns.len();
    let mut normal = vec![0.0; m * m];
    let mut right = vec![0.0; m];
    for i in 0..m {
        right[i] = -dot(columns[i], residual) - precision[i] * (at[i] - origin[i]);
        for j in 0..=i {
            let x = if i < known {
                calibration.product(i, j)
            } else {
                dot(columns[i], columns[j])
            };
            normal[i * m + j] = x;
            normal[j * m + i] = x;
        }
        normal[i * m + i] += precision[i] + 1e-9;
    }
    let mut held: Vec<Option<f64>> = vec![None; m];
    for _ in 0..=m {
        let free: Vec<usize> = (0..m).filter(|i| held[*i].is_none()).collect();
        if free.is_empty() {
            break;
        }
        let f = free.len();
        let mut a = vec![0.0; f * f];
        let mut b = vec![0.0; f];
        for (i, p) in free.iter().enumerate() {
            b[i] = right[*p];
            for (q, h) in held.iter().enumerate() {
                if let Some(h) = h {
                    b[i] -= normal[p * m + q] * h;
                }
            }
            for (j, q) in free.iter().enumerate() {
                a[i * f + j] = normal[p * m + q];
            }
        }
        let Some(step) = solve(&a, &[b]) else {
            return vec![0.0; m];
        };
        let mut worst: Option<(usize, f64, f64)> = None;
        for (i, p) in free.iter().enumerate() {
            let there = at[*p] + step[0][i];
            let inside = there.clamp(least[*p], most[*p]);
            let scale = (1.0 / normal[p * m + p]).sqrt().max(1e-300);
            let over = (there - inside).abs() / scale;
            if over > 1e-9 && worst.is_none_or(|w| over > w.1) {
                worst = Some((*p, over, inside - at[*p]));
            }
        }
        match worst {
            Some((p, _, step)) => held[p] = Some(step),
            None => {
                let mut all: Vec<f64> = held.iter().map(|h| h.unwrap_or(0.0)).collect();
                for (i, p) in free.iter().enumerate() {
                    all[*p] = step[0][i];
                }
                return all;
            }
        }
    }
    held.iter().map(|h| h.unwrap_or(0.0)).collect()
}

impl Baseline {
    /// Levels and calibration in turn.
    pub fn fit(
        rides: &Rides,
        free: &FreeNoise,
        model: Model,
        all: Vec<Calibrated>,
        progress: &mut dyn FnMut(&str),
    ) -> Option<Self> {
        let mut this = Self {
            z: vec![0.0; all.len()],
            model,
            all,
            columns: Arc::default(),
            cost: 0.0,
        };
        progress("noise levels");
        // Long rides: most of the way on an excerpt.
        let excerpt = rides.excerpt(&this.model);
        match excerpt.filter(|e| 3 * e.readings() < rides.readings()) {
            Some(excerpt) => {
                this.model = fit_levels(&excerpt, free, &this.model, 6);
                this.calibrate(&excerpt, 2)?;
                this.model = fit_levels(&excerpt, free, &this.model, 3);
            }
            None => {
                this.model = fit_levels(rides, free, &this.model, 5);
                this.calibrate(rides, 2)?;
                this.model = fit_levels(rides, free, &this.model, 3);
            }
        }
        progress("calibration");
        this.calibrate(rides, 2)?;
        this.model = fit_levels(rides, free, &this.model, 3);
        this.calibrate(rides, 2)?;
        Some(this)
    }

    /// Gauss-Newton steps on the calibration parameters at fixed levels, `most` of them.
    fn calibrate(&mut self, rides: &Rides, most: usize) -> Option<()> {
        let prior = |z: &[f64]| 0.5 * dot(z, z);
        self.model = moved(&self.model, &self.all, &self.z)?;
        let mut passes = Passes::run(rides, &self.model, true)?;
        self.cost = passes.minus_log_likelihood() + prior(&self.z);
        let limit = THRESHOLDS.calibration_box_sd;
        for _ in 0..most {
            self.columns = Columns::of(rides, self, &passes);
            let kept = &self.columns.list;
            let m = kept.len();
            if m == 0 {
                break;
            }
            let at: Vec<f64> = kept.iter().map(|(i, _)| self.z[*i]).collect();
            let step = bounded_step(
                &passes.whitened(),
                &self.columns,
                &[],
                &vec![1.0; m],
                &at,
                &vec![0.0; m],
                &vec![-limit; m],
                &vec![limit; m],
            );
            let mut share = 1.0;
            let mut gained = 0.0;
            while share > 0.1 {
                let mut there = self.z.clone();
                for ((i, _), d) in kept.iter().zip(&step) {
                    there[*i] = (there[*i] + share * d).clamp(-limit, limit);
                }
                let trial = moved(&self.model, &self.all, &there);
                let found = trial.and_then(|m| Passes::run(rides, &m, true).map(|p| (m, p)));
                if let Some((m, p)) = found {
                    let value = p.minus_log_likelihood() + prior(&there);
                    if value < self.cost {
                        gained = self.cost - value;
                        (self.model, passes, self.cost, self.z) = (m, p, value, there);
                        break;
                    }
                }
                share *= 0.4;
            }
            if gained < 0.1 {
                break;
            }
        }
        Some(())
    }
}

/// Prepares rides for a plant.
pub fn prepare(rides: Vec<Ride>, plant: &Plant) -> Rides {
    Rides(rides.into_iter().map(|r| Prepared::new(r, plant)).collect())
}
