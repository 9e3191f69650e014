//! The rides of one use, and one model's passes over them.

use super::thresholds::THRESHOLDS;
use crate::engine::course::Course;
use crate::engine::{Model, Pass, Plant, Prepared, Ride, sensitivity};

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

    /// Shortest delay that the clocks of the rides can tell, s.
    pub fn clock_s(&self) -> f64 {
        let jitters = self.0.iter().map(|r| r.ride.clock_jitter_sd_s);
        THRESHOLDS.clock_jitter_sd * jitters.fold(0.0, f64::max)
    }

    pub fn readings(&self) -> usize {
        self.0.iter().map(|r| r.course.readings.len()).sum()
    }
}

/// One model's passes over rides.
pub struct Passes {
    pub plant: Plant,
    pub passes: Vec<Pass>,
    pub courses: Vec<Option<Course>>,
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

    pub fn course<'a>(&'a self, rides: &'a Rides, index: usize) -> &'a Course {
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

/// Prepares rides for a plant.
pub fn prepare(rides: Vec<Ride>, plant: &Plant) -> Rides {
    Rides(rides.into_iter().map(|r| Prepared::new(r, plant)).collect())
}
