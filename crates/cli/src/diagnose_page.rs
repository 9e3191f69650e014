//! From an answer to the page that shows it.

use twinhub_diagnose::{Answer, Verdict};
use twinhub_report::diagnose::{
    CandidateBar, CauseRow, ChannelTrace, CurvePlot, DiagnosePage, GainRow, LatentPlot,
    SpectrumPlot,
};
use twinhub_report::page::Tone;

/// The page of an answer.
pub fn page(answer: &Answer) -> DiagnosePage {
    let gains = answer.gain.iter().flat_map(|(channel, gain)| {
        gain.rmse_by_horizon_s
            .iter()
            .map(move |(horizon, rmse)| GainRow {
                channel: channel.clone(),
                horizon_s: horizon.clone(),
                rmse: *rmse,
                vaf: [
                    gain.nominal_vaf,
                    gain.calibrated_vaf,
                    gain.extended_vaf,
                    gain.ceiling_vaf,
                ],
            })
    });
    let mut unseen: Vec<[String; 2]> = answer
        .detection_limits
        .iter()
        .flat_map(|(name, limits)| {
            limits
                .iter()
                .map(move |(p, x)| [name.clone(), format!("{p} below {x:.2e}")])
        })
        .collect();
    unseen.extend(
        answer
            .not_testable
            .iter()
            .map(|n| [n.mechanism.clone(), n.why.clone()]),
    );
    DiagnosePage {
        title: answer.study.clone(),
        verdict: answer.verdict.name().to_owned(),
        tone: match answer.verdict {
            Verdict::NoEffect | Verdict::Cause | Verdict::Causes => Tone::Good,
            Verdict::BadData => Tone::Bad,
            _ => Tone::Even,
        },
        statements: answer.statements.clone(),
        traces: answer
            .pictures
            .traces
            .iter()
            .map(|t| ChannelTrace {
                ride: t.ride.clone(),
                quantity: t.quantity.clone(),
                t_s: t.t_s.clone(),
                measured: t.measured.clone(),
                calibrated: t.calibrated.clone(),
                extended: t.extended.clone(),
            })
            .collect(),
        spectra: answer
            .pictures
            .spectra
            .iter()
            .map(|s| SpectrumPlot {
                equation: s.equation.clone(),
                frequency_hz: s.frequency_hz.clone(),
                before: s.before.clone(),
                after: s.after.clone(),
                limit: s.limit.clone(),
            })
            .collect(),
        latent: answer.pictures.latent.as_ref().map(|l| LatentPlot {
            equation: l.equation.clone(),
            ride: l.trace.ride.clone(),
            t_s: l.trace.t_s.clone(),
            torque_nm: l.trace.torque_nm.clone(),
            curve: l.curve.as_ref().map(|c| CurvePlot {
                over: format!("{}, {}", c.over, c.unit),
                x: c.x.clone(),
                torque_nm: c.torque_nm.clone(),
                low_nm: c.low_nm.clone(),
                high_nm: c.high_nm.clone(),
            }),
        }),
        candidates: answer
            .candidates
            .iter()
            .map(|c| CandidateBar {
                name: c.mechanism.clone(),
                nats: c.held_out_gain_nats.unwrap_or(c.fit_gain_nats),
                half_width: c.held_out_error_nats.map_or(0.0, |e| 1.96 * e),
                bracketed: answer
                    .causes
                    .iter()
                    .any(|cause| cause.set.len() > 1 && cause.set.contains(&c.mechanism)),
            })
            .collect(),
        causes: answer
            .causes
            .iter()
            .flat_map(|cause| {
                cause.parameters.iter().map(|(name, v)| CauseRow {
                    mechanism: cause.mechanism.clone(),
                    state: if cause.confirmed {
                        "confirmed"
                    } else {
                        "provisional"
                    }
                    .to_owned(),
                    parameter: name.clone(),
                    value: v.value,
                    ci95: v.ci95,
                    set: cause.set.join(", "),
                })
            })
            .collect(),
        gains: gains.collect(),
        next: answer
            .next_experiment
            .as_ref()
            .map(|n| format!("{} (separates {})", n.what, n.separates.join(", "))),
        unseen,
        details: format!(
            "{}\nthresholds {}\ncalibration\n{}",
            answer.tool,
            answer.thresholds,
            answer
                .calibration
                .iter()
                .map(|(s, v)| format!("  {s:<6} {v:.6}"))
                .collect::<Vec<_>>()
                .join("\n")
        ),
    }
}
