//! How wrong the model is, in plain sentences.

use super::result::{ChannelResult, Comparison, HorizonResult};

/// "83 % of steer_rad and 88 % of yaw_rate_rad_s, but nothing of roll_rad (VAF -0.15)".
fn shares(main: &[(&String, HorizonResult)]) -> String {
    let (some, none): (Vec<_>, Vec<_>) = main
        .iter()
        .partition(|(_, h)| h.vaf.is_some_and(|v| v > 0.0));
    let list = |parts: Vec<String>| parts.join(", ");
    let some = list(
        some.iter()
            .map(|(n, h)| format!("{:.0} % of {n}", 100.0 * h.vaf.unwrap_or(0.0)))
            .collect(),
    );
    let none = list(
        none.iter()
            .map(|(n, h)| {
                format!(
                    "{n} (VAF {})",
                    h.vaf.map_or("undefined".to_owned(), |v| format!("{v:.2}"))
                )
            })
            .collect(),
    );
    match (some.is_empty(), none.is_empty()) {
        (false, true) => some,
        (true, _) => format!("nothing of {none}"),
        (false, false) => format!("{some}, but nothing of {none}"),
    }
}

fn at(channel: &ChannelResult, horizon: &str) -> Option<HorizonResult> {
    channel.horizons.get(horizon).cloned().flatten()
}

pub fn statements(comparison: &Comparison) -> Vec<String> {
    let mut all = vec![];
    let main: Vec<(&String, HorizonResult)> = comparison
        .channels
        .iter()
        .filter_map(|(name, c)| Some((name, at(c, "0.5")?)))
        .collect();
    if main.is_empty() {
        all.push("No window is long enough for a prediction over 0.5 s.".to_owned());
    } else {
        all.push(format!(
            "Over 0.5 s the model explains, of the variance, {}.",
            shares(&main)
        ));
        let useless: Vec<&str> = main
            .iter()
            .filter(|(_, h)| h.held_rmse.is_some_and(|r| h.rmse >= r))
            .map(|(n, _)| n.as_str())
            .collect();
        all.push(match useless.len() {
            0 => "It predicts every channel better than holding the last reading does.".to_owned(),
            n if n == main.len() => {
                "It predicts no channel better than holding the last reading does.".to_owned()
            }
            _ => format!(
                "It predicts no better than holding the last reading in {}.",
                useless.join(", ")
            ),
        });
    }
    for (name, channel) in &comparison.channels {
        if let Some(r) = channel.change_correlation.filter(|r| *r < -0.3) {
            all.push(format!("{name} moves against its prediction (correlation {r:.2}): check its sign, and those of the inputs."));
        }
    }
    all.extend(
        comparison
            .relations
            .iter()
            .filter_map(|r| r.warning.clone())
            .map(|w| format!("{w}.")),
    );
    let rate = comparison.growth_rate_1_s;
    let speed = comparison.mean_speed_m_s;
    let kind = match comparison.growth_omega_rad_s {
        omega if omega > 1e-6 => format!(
            "oscillating at {:.2} Hz",
            omega / (2.0 * std::f64::consts::PI)
        ),
        _ => "not oscillating".to_owned(),
    };
    all.push(match rate > 0.0 {
        true => format!(
            "At {speed:.2} m/s the model is unstable, {kind}: an error grows e-fold in {:.2} s, {:.1}-fold over 2 s. A free run \
             is shown for at most {:.2} s.",
            1.0 / rate,
            libm::exp(2.0 * rate),
            super::GROWTH_TIMES / rate
        ),
        false => format!("At {speed:.2} m/s the model is stable; its slowest mode, {kind}, decays at {:.2} 1/s.", -rate),
    });
    if !comparison.noise.converged {
        all.push(
            "The noise levels did not settle; the figures stand for those of the last round."
                .to_owned(),
        );
    }
    all
}
