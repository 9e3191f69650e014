//! Modes and health flags of the controller: every fault has a code, a cause, what the rider is
//! told, and how it clears.

/// What the stabilizer is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Mode {
    /// Switched off by the rider or by configuration; no torque.
    #[default]
    Off = 0,
    /// Switched on and healthy; conditions for torque are not met (too slow, too fast).
    Ready = 1,
    /// The pair is applied.
    Active = 2,
    /// A sensor is missing; the pair is reduced or ramped out.
    Degraded = 3,
    /// No torque until the fault clears.
    Fault = 4,
}

impl Mode {
    /// The mode with number `value`; an unknown number counts as `Fault`.
    pub const fn from_u32(value: u32) -> Self {
        match value {
            0 => Self::Off,
            1 => Self::Ready,
            2 => Self::Active,
            3 => Self::Degraded,
            _ => Self::Fault,
        }
    }

    /// The name as logs and reports print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Ready => "ready",
            Self::Active => "active",
            Self::Degraded => "degraded",
            Self::Fault => "fault",
        }
    }
}

/// A set of health flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Health(u32);

/// One line of the table of health flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HealthEntry {
    /// The flag.
    pub flag: Health,
    /// Stable code, as logged.
    pub code: &'static str,
    /// What raises it.
    pub cause: &'static str,
    /// What the display on the bar says.
    pub told: &'static str,
    /// How it clears.
    pub clears: &'static str,
}

macro_rules! health_flags {
    ($($(#[$doc:meta])* $name:ident = $bit:literal, $code:literal, $cause:literal, $told:literal, $clears:literal;)*) => {
        impl Health {
            $($(#[$doc])* pub const $name: Health = Health(1 << $bit);)*
            /// Every flag with its meaning.
            pub const TABLE: &'static [HealthEntry] = &[$(HealthEntry {
                flag: Health::$name, code: $code, cause: $cause, told: $told, clears: $clears,
            },)*];
        }
    };
}

health_flags! {
    /// No fresh frame from the bicycle.
    LINK_LOST = 0, "link_lost", "no frame from the bicycle for longer than the link limit", "stabilizer lost contact", "fresh frames for one second";
    /// Roll is unknown.
    ROLL_MISSING = 1, "roll_missing", "neither roll nor gyro samples are fresh and finite", "balance sensor missing", "fresh samples for one second";
    /// Steer is unknown.
    STEER_MISSING = 2, "steer_missing", "steer samples are stale, not finite or beyond the steering stop", "steer sensor missing", "fresh samples for one second";
    /// Speed is unknown.
    SPEED_MISSING = 3, "speed_missing", "wheel-speed samples are stale, not finite or beyond the range", "speed sensor missing", "fresh samples for one second";
    /// The rider's wishes are unknown.
    INTENT_MISSING = 4, "intent_missing", "brake, pedal and switch readings are stale or not finite", "brake sensor missing", "fresh readings for one second";
    /// Time went backwards or jumped.
    TIME_JUMP = 5, "time_jump", "the tick's time did not advance, or advanced by more than the link limit", "stabilizer clock fault", "regular ticks for one second";
    /// The configuration breaks a limit of the guard.
    CONFIG_REFUSED = 6, "config_refused", "the schedule or a limit is not finite, not ordered or beyond the hard limits", "stabilizer not configured", "a valid configuration and a restart";
    /// The bicycle lies on its side.
    FALLEN = 7, "fallen", "roll is beyond the fall limit", "fallen: no torque until upright", "upright for one second";
    /// Steer and yaw rate contradict each other.
    STEER_DOUBT = 8, "steer_doubt", "steer angle and yaw rate have not fitted each other for half a second", "steer sensor doubted", "values that fit for one second";
    /// The three speeds contradict each other.
    SPEED_DOUBT = 9, "speed_doubt", "wheel speeds and speedometer have not fitted each other for half a second", "speed sensor doubted", "values that fit for one second";
}

impl Health {
    /// Nothing to report.
    pub const OK: Health = Health(0);

    /// The bits, as sent.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Flags from bits as received; unknown bits are kept, so that a newer peer is not hidden.
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Both sets together.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// `self` without `other`.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// True if any flag of `other` is raised.
    pub const fn any(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// True if nothing is raised.
    pub const fn is_ok(self) -> bool {
        self.0 == 0
    }
}

/// A set of limits that held a command back in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct LimitedBy(u32);

/// One line of the table of limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitEntry {
    /// The limit.
    pub limit: LimitedBy,
    /// Stable code, as logged.
    pub code: &'static str,
    /// What it does to the command.
    pub effect: &'static str,
}

macro_rules! limits {
    ($($(#[$doc:meta])* $name:ident = $bit:literal, $code:literal, $effect:literal;)*) => {
        impl LimitedBy {
            $($(#[$doc])* pub const $name: LimitedBy = LimitedBy(1 << $bit);)*
            /// Every limit with its effect.
            pub const TABLE: &'static [LimitEntry] = &[$(LimitEntry {
                limit: LimitedBy::$name, code: $code, effect: $effect,
            },)*];
        }
    };
}

limits! {
    /// The largest torque of profile and configuration.
    MAGNITUDE = 0, "magnitude", "torque held at the largest of profile and configuration";
    /// The slow ramp.
    RAMP = 1, "ramp", "torque still on its way to the demand";
    /// Friction and load at the wheels.
    FRICTION = 2, "friction", "torque held inside the friction ellipses, at once";
    /// The thermal average of motor power.
    POWER = 3, "power", "torque held so that the average power stays below its limit";
    /// A brake lever is pulled.
    LEVER = 4, "lever", "no torque, at once";
    /// A wheel slips.
    SLIP = 5, "slip", "no torque, at once, and for a second after";
    /// A wheel stands still or rolls backwards.
    STANDSTILL = 6, "standstill", "no braking torque on that wheel, at once";
    /// Assistance is not allowed: no pedalling, or above 25 km/h.
    NET_DRIVE = 7, "net_drive", "rear torque no larger than what balances the front, at once";
    /// The mode allows no torque, or less.
    MODE = 8, "mode", "torque ramped out or reduced";
    /// Nothing fresh from the bicycle.
    LINK = 9, "link", "torque ramped out within 200 ms";
    /// Wheel speeds unknown to the guard.
    BLIND = 10, "blind", "torque ramped out within half a second";
    /// The rider's wishes unknown to the guard.
    INTENT = 11, "intent", "torque ramped out slowly";
    /// A slow wheel could stop before its slip is seen.
    TURNING = 12, "turning", "braking torque held below what the square of the wheel's speed allows, at once";
    /// The fork has used much of its life.
    FORK = 13, "fork", "largest pair reduced as the fork's life is used";
    /// Battery and motors give or take no more power.
    SUPPLY = 14, "supply", "torque held at the power that battery and motors have, at once";
}

impl LimitedBy {
    /// Nothing held the command back.
    pub const NONE: LimitedBy = LimitedBy(0);

    /// The bits, as sent.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Limits from bits as received; unknown bits are kept.
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Both sets together.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True if any limit of `other` held the command back.
    pub const fn any(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_is_one_bit_of_its_own_with_words() {
        let mut seen = 0;
        for entry in Health::TABLE {
            assert_eq!(entry.flag.bits().count_ones(), 1, "{}", entry.code);
            assert_eq!(seen & entry.flag.bits(), 0, "{} shares a bit", entry.code);
            seen |= entry.flag.bits();
            assert!(!entry.cause.is_empty() && !entry.told.is_empty() && !entry.clears.is_empty());
        }
    }

    #[test]
    fn every_limit_is_one_bit_of_its_own_with_words() {
        let mut seen = 0;
        for entry in LimitedBy::TABLE {
            assert_eq!(entry.limit.bits().count_ones(), 1, "{}", entry.code);
            assert_eq!(seen & entry.limit.bits(), 0, "{} shares a bit", entry.code);
            seen |= entry.limit.bits();
            assert!(!entry.effect.is_empty());
        }
    }
}
