//! What a ride writes into its log.

use crate::closed_loop::Settings;
use crate::error::RideError;
use crate::metrics::Metrics;
use crate::record::{LinkRow, RiderRow, TruthRow};
use crate::setup::Ride;
use std::path::Path;
use twinhub_link::{LinkEvent, Timing};
use twinhub_log::{Digest, Event, Level, Metadata, RideLog, ScenePose, Topic};
use twinhub_types::{Instant, Measurement, Output, PlantFrame, RiderIntent};

/// Scene pictures in the log, every so many ticks (20 Hz).
const SCENE_EVERY: u64 = 50;

/// The log of a ride.
pub(crate) struct Logger {
    log: RideLog,
    truth: Topic<TruthRow>,
    rider: Topic<RiderRow>,
    measurement: Topic<Measurement>,
    intent: Topic<RiderIntent>,
    output: Topic<Output>,
    link: Topic<LinkRow>,
    health: u32,
    mode: u32,
}

impl Logger {
    /// `real_time`: the ride must not wait for the disk.
    pub(crate) fn create(
        path: &Path,
        ride: &Ride,
        settings: &Settings,
        real_time: bool,
    ) -> Result<Self, RideError> {
        let config = ride.to_toml();
        let metadata = Metadata {
            version: settings.version.clone(),
            git_hash: settings.git_hash.clone(),
            config_digest: twinhub_log::digest_text(&config),
            seed: ride.course.seed,
            extra: [
                ("course", ride.name.clone()),
                ("bicycle", ride.bicycle.name.clone()),
                ("rider", ride.course.rider.clone()),
                ("law", ride.course.law.clone()),
                (
                    "stabilizer",
                    if ride.stabilizer_on { "on" } else { "off" }.to_owned(),
                ),
            ]
            .map(|(key, value)| (key.to_owned(), value))
            .into(),
        };
        let create = if real_time {
            RideLog::create_for_real_time
        } else {
            RideLog::create
        };
        let mut log = create(path, &metadata, &config)?;
        let shape = ride.bicycle.shape();
        log.scene_topic(twinhub_log::BicycleShape {
            wheelbase_m: shape.wheelbase_m,
            steer_axis_tilt_rad: shape.steer_tilt_rad,
            trail_m: shape.trail_m,
            rear_radius_m: shape.rear_radius_m,
            front_radius_m: shape.front_radius_m,
        })?;
        Ok(Self {
            truth: log.topic(twinhub_log::PLANT_TRUTH, Digest::Digested)?,
            rider: log.topic(twinhub_log::RIDER_STATE, Digest::Digested)?,
            measurement: log.topic(twinhub_log::SENSOR_MEASUREMENT, Digest::Digested)?,
            intent: log.topic(twinhub_log::RIDER_INTENT, Digest::Digested)?,
            output: log.topic(twinhub_log::CONTROL_OUTPUT, Digest::Digested)?,
            link: log.topic(twinhub_log::LINK_TIMING, Digest::Left)?,
            log,
            health: 0,
            mode: u32::MAX,
        })
    }

    pub(crate) fn tick(
        &mut self,
        now: Instant,
        tick: u64,
        truth: &TruthRow,
        rider: &RiderRow,
        frame: &PlantFrame,
        output: Option<&Output>,
    ) -> Result<(), RideError> {
        self.log.write(self.truth, now, truth)?;
        self.log.write(self.rider, now, rider)?;
        self.log.write(self.measurement, now, &frame.measurement)?;
        self.log.write(self.intent, now, &frame.intent)?;
        if tick.is_multiple_of(SCENE_EVERY) {
            self.log.scene(
                now,
                &ScenePose {
                    x_m: truth.x_m,
                    y_m: truth.y_m,
                    yaw_rad: truth.yaw_rad,
                    roll_rad: truth.roll_rad,
                    steer_rad: truth.steer_rad,
                    rear_turned_rad: truth.rear_wheel_rate_rad_s * now.as_secs_f64(),
                    front_turned_rad: truth.front_wheel_rate_rad_s * now.as_secs_f64(),
                },
            )?;
        }
        match output {
            Some(output) => {
                self.log.write(self.output, now, output)?;
                self.health_events(now, output)
            }
            None => Ok(()),
        }
    }

    /// An event for every change of mode and every flag that rises or falls.
    fn health_events(&mut self, now: Instant, output: &Output) -> Result<(), RideError> {
        if output.mode != self.mode {
            self.mode = output.mode;
            let mode = twinhub_types::Mode::from_u32(output.mode).name();
            self.event(
                now,
                Level::Info,
                "supervisor.mode",
                &format!("mode: {mode}"),
            )?;
        }
        let changed = output.health ^ self.health;
        if changed != 0 {
            for entry in twinhub_types::Health::TABLE {
                let bit = entry.flag.bits();
                if changed & bit != 0 {
                    let code = format!("supervisor.{}", entry.code);
                    if output.health & bit != 0 {
                        self.event(now, Level::Warning, &code, entry.cause)?;
                    } else {
                        self.event(now, Level::Info, &code, "cleared")?;
                    }
                }
            }
            self.health = output.health;
        }
        Ok(())
    }

    /// Something that happened on the link.
    pub(crate) fn link_event(&mut self, at: Instant, event: &LinkEvent) -> Result<(), RideError> {
        let level = if event.warning {
            Level::Warning
        } else {
            Level::Info
        };
        self.event(at, level, event.code, &event.text)
    }

    /// How the link has done so far, where somebody measures it.
    pub(crate) fn link(&mut self, at: Instant, timing: Option<&Timing>) -> Result<(), RideError> {
        match timing {
            Some(timing) => Ok(self.log.write(self.link, at, &LinkRow::from(timing))?),
            None => Ok(()),
        }
    }

    pub(crate) fn event(
        &mut self,
        at: Instant,
        level: Level,
        code: &str,
        text: &str,
    ) -> Result<(), RideError> {
        Ok(self.log.event(at, &Event { level, code, text })?)
    }

    pub(crate) fn finish(
        mut self,
        metrics: &Metrics,
    ) -> Result<twinhub_log::LogSummary, RideError> {
        self.log.note("fell", &metrics.fell.to_string());
        self.log.note("ticks", &metrics.ticks.to_string());
        Ok(self.log.finish()?)
    }
}
