//! Rides of a study: time, windows, and whether their channels make a set.

use super::check::{Checker, LONGEST_LAG_S};
use super::raw::{RawChannel, RawRide};
use super::{ChannelSpec, RideSpec, Role, StudyError, TimeSpec, WindowSpec};
use crate::quantity::Quantity;
use std::ops::Range;
use toml::Spanned;

impl Checker<'_> {
    pub(super) fn ride(&self, raw: &Spanned<RawRide>) -> Result<RideSpec, StudyError> {
        let ride = raw.get_ref();
        let (time, jitter) = self.time(ride)?;
        let channels = ride
            .channel
            .iter()
            .map(|c| self.channel(c))
            .collect::<Result<Vec<_>, _>>()?;
        self.channel_set(&raw.span(), &channels, &ride.channel)?;
        Ok(RideSpec {
            file: ride.file.get_ref().clone(),
            place: self.place(&ride.file.span()),
            usage: ride.usage,
            rider: ride.rider.clone().unwrap_or_else(|| "none".to_owned()),
            hands: ride.hands,
            ground: ride.ground,
            time,
            clock_jitter_sd_s: jitter,
            windows: self.windows(ride)?,
            laws: ride
                .law
                .iter()
                .map(|l| self.law(l))
                .collect::<Result<_, _>>()?,
            channels,
        })
    }

    fn time(&self, ride: &RawRide) -> Result<(TimeSpec, f64), StudyError> {
        let log = ride.file.get_ref().ends_with(".mcap");
        let Some(raw) = &ride.time else {
            return match log {
                true => Ok((TimeSpec::Log, 0.0)),
                false => self.refuse(
                    &ride.file.span(),
                    "a CSV ride without time",
                    "time = { column = NAME } or { rate_hz = NUMBER }",
                ),
            };
        };
        let (time, span) = (raw.get_ref(), raw.span());
        let spec = match (&time.column, time.rate_hz) {
            (None, None) if log => TimeSpec::Log,
            (Some(_), _) | (_, Some(_)) if log => {
                return self.refuse(
                    &span,
                    "a time column or rate for an MCAP log",
                    "no such key: every topic has its own sample times",
                );
            }
            (Some(column), None) => TimeSpec::Column(column.clone()),
            (None, Some(rate)) if rate.is_finite() && rate > 0.0 && rate <= 1e5 => {
                TimeSpec::RateHz(rate)
            }
            (column, rate) => {
                let found = format!("time with column {column:?} and rate_hz {rate:?}");
                return self.refuse(
                    &span,
                    found,
                    "either { column = NAME } or { rate_hz = NUMBER } above 0, at most 1e5",
                );
            }
        };
        let jitter = time.clock_jitter_sd_s.unwrap_or(0.0);
        match (0.0..=LONGEST_LAG_S).contains(&jitter) {
            true => Ok((spec, jitter)),
            false => self.refuse(&span, format!("clock_jitter_sd_s = {jitter}"), "0 to 10 s"),
        }
    }

    fn windows(&self, ride: &RawRide) -> Result<Option<Vec<WindowSpec>>, StudyError> {
        let Some(raw) = &ride.windows else {
            return Ok(None);
        };
        let mut windows: Vec<WindowSpec> = vec![];
        for window in raw {
            let [start_s, end_s] = window.get_ref().s;
            let before = windows.last().map(|w| w.end_s);
            let ordered = start_s.is_finite() && end_s.is_finite() && start_s < end_s;
            if !ordered || before.is_some_and(|b| start_s < b) {
                let found = match before {
                    Some(b) if ordered => {
                        format!("window [{start_s}, {end_s}] after one that ends at {b}")
                    }
                    _ => format!("window [{start_s}, {end_s}]"),
                };
                return self.refuse(
                    &window.span(),
                    found,
                    "[a, b] in seconds with a < b, ordered and not overlapping",
                );
            }
            windows.push(WindowSpec {
                start_s,
                end_s,
                usage: window.get_ref().usage.unwrap_or(ride.usage),
                place: self.place(&window.span()),
            });
        }
        match windows.is_empty() {
            true => self.refuse(
                &ride.file.span(),
                "windows = []",
                "at least one window, or no `windows` for the whole ride",
            ),
            false => Ok(Some(windows)),
        }
    }

    fn channel_set(
        &self,
        ride: &Range<usize>,
        channels: &[ChannelSpec],
        raw: &[Spanned<RawChannel>],
    ) -> Result<(), StudyError> {
        let used = |c: &&ChannelSpec| c.role != Role::Check;
        match channels
            .iter()
            .filter(used)
            .filter(|c| c.quantity == Quantity::Speed)
            .count()
        {
            1 => {}
            0 => {
                return self.refuse(
                    ride,
                    "a ride without speed_m_s",
                    "one speed_m_s channel with role input or output",
                );
            }
            n => {
                let second = raw
                    .iter()
                    .filter(|c| {
                        *c.get_ref().quantity.get_ref() == Quantity::Speed
                            && *c.get_ref().role.get_ref() != Role::Check
                    })
                    .nth(1);
                return self.refuse(
                    &second.map_or(ride.clone(), |c| c.span()),
                    format!("{n} speed_m_s channels"),
                    "one with role input or output, others as check",
                );
            }
        }
        if !channels.iter().any(|c| c.role == Role::Output) {
            return self.refuse(
                ride,
                "a ride without outputs",
                "at least one channel with role output",
            );
        }
        for (index, channel) in channels.iter().enumerate() {
            let again = channels[..index].iter().any(|c| {
                c.role == Role::Input
                    && channel.role == Role::Input
                    && c.quantity == channel.quantity
            });
            // Two ropes may pull at two places.
            if again && channel.quantity != Quantity::LateralForce {
                return self.refuse(
                    &raw[index].span(),
                    format!("a second input {}", channel.quantity),
                    "each input quantity once",
                );
            }
        }
        Ok(())
    }
}
