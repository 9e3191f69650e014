//! The picture of every paper on bicycle stability: real and imaginary parts of the eigenvalues over
//! speed, the stable ranges shaded. One SVG without scripts or outside parts, for light and dark
//! backgrounds; line styles differ as well as colours.

use std::fmt::Write;
use twinhub_linear::{Critical, Eigenpair, ModeName, Modes, follow};

const WIDTH: f64 = 760.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 740.0;
/// Top and bottom of the panel of real parts, and of imaginary parts.
const REAL: [f64; 2] = [86.0, 336.0];
const IMAGINARY: [f64; 2] = [366.0, 526.0];
const HEIGHT: f64 = 578.0;
/// Real parts below this are cut off: a caster mode at speed would flatten the rest, 1/s.
const LOWEST_REAL_1_S: f64 = -10.0;

const STYLE: &str = "\
.tm{--ink:#1b1f24;--soft:#5b6470;--grid:#e3e7ec;--paper:#fff;--stable:#2e9e5b;--weave:#0067a5;--capsize:#c14a00;--caster:#7a4bb0;--other:#6b7280;font:13px system-ui,-apple-system,'Segoe UI',sans-serif}
@media(prefers-color-scheme:dark){.tm{--ink:#e8ebef;--soft:#a3adb9;--grid:#30363e;--paper:#14171b;--stable:#43c07a;--weave:#5cb8f2;--capsize:#f59a52;--caster:#c09af0;--other:#9aa3af}}
.tm .paper{fill:var(--paper)}.tm text{fill:var(--ink)}.tm .soft{fill:var(--soft)}.tm .title{font-size:16px;font-weight:600}
.tm .grid{stroke:var(--grid)}.tm .zero{stroke:var(--soft);stroke-width:1.2}.tm .frame{fill:none;stroke:var(--soft)}
.tm .stable{fill:var(--stable);opacity:.16}.tm .mark{stroke:var(--soft);stroke-dasharray:2 3}
.tm .line{fill:none;stroke-width:2.2;stroke-linejoin:round;stroke-linecap:round}
.tm .weave{stroke:var(--weave)}.tm .capsize{stroke:var(--capsize);stroke-dasharray:9 5}.tm .caster{stroke:var(--caster);stroke-dasharray:2 5}.tm .other{stroke:var(--other)}";

/// What is drawn.
pub struct ModesPicture<'a> {
    /// Heading, for instance the bicycle.
    pub title: &'a str,
    /// Second line, for instance the motor torques.
    pub subtitle: &'a str,
    /// Modes at closely spaced speeds, at least two.
    pub modes: &'a Modes,
}

/// Plain text made safe for SVG and HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A step of 1, 2 or 5 times a power of ten that divides `span` into about `count`.
fn tick_step(span: f64, count: f64) -> f64 {
    let raw = span / count;
    let power = 10.0_f64.powf(raw.log10().floor());
    let lead = raw / power;
    power
        * if lead < 1.5 {
            1.0
        } else if lead < 3.5 {
            2.0
        } else if lead < 7.5 {
            5.0
        } else {
            10.0
        }
}

fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let step = tick_step(high - low, count);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

fn label(value: f64, step: f64) -> String {
    let digits = (-step.log10()).ceil().clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}").replace('-', "\u{2212}")
}

/// Linear map from a range to pixels.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }
}

/// One branch as runs of connected points.
fn path(points: impl Iterator<Item = Option<(f64, f64)>>) -> String {
    let (mut d, mut pen) = (String::new(), 'M');
    for point in points {
        match point {
            Some((x, y)) => {
                let _ = write!(d, "{pen}{x:.1} {y:.1}");
                pen = 'L';
            }
            None => pen = 'M',
        }
    }
    d
}

impl ModesPicture<'_> {
    /// The picture as an `<svg>` element, for a file of its own or inline.
    pub fn svg(&self) -> String {
        let points = &self.modes.points;
        let speeds: Vec<f64> = points.iter().map(|p| p.speed_m_s).collect();
        let low = speeds.first().copied().unwrap_or(0.0);
        let high = speeds
            .last()
            .copied()
            .filter(|h| *h > low)
            .unwrap_or(low + 1.0);
        let x = Axis {
            low,
            high,
            from: LEFT,
            to: RIGHT,
        };

        let family: Vec<Vec<Eigenpair>> = points
            .iter()
            .map(|p| p.modes.iter().map(|m| m.pair.clone()).collect())
            .collect();
        let start = family.len().saturating_sub(1);
        let branches = follow(&family, start);
        let name = |b: usize| {
            points
                .get(start)
                .map_or(ModeName::Other, |p| p.modes[b].name)
        };
        let count = family.first().map_or(0, Vec::len);

        let all = || family.iter().flatten().map(|p| p.value);
        let (bottom, top) = all().fold((-1.0_f64, 1.0_f64), |(a, b), s| (a.min(s.re), b.max(s.re)));
        let bottom = bottom.max(LOWEST_REAL_1_S);
        let step = tick_step(top - bottom, 6.0);
        let real = Axis {
            low: (bottom / step).floor() * step,
            high: (top / step).ceil() * step,
            from: REAL[1],
            to: REAL[0],
        };
        let fastest = all().fold(1.0_f64, |a, s| a.max(s.im));
        let step = tick_step(fastest, 4.0);
        let imaginary = Axis {
            low: 0.0,
            high: (fastest / step).ceil() * step,
            from: IMAGINARY[1],
            to: IMAGINARY[0],
        };

        let mut out = format!(
            "<svg class=\"tm\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" style=\"max-width:100%;height:auto\" role=\"img\">\n<title>Eigenvalues over speed: {}</title>\n\
             <style>{STYLE}</style>\n<defs><clipPath id=\"tm-real\"><rect x=\"{LEFT}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\
             </clipPath></defs>\n<rect class=\"paper\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>\n\
             <text class=\"title\" x=\"{LEFT}\" y=\"26\">{}</text>\n<text class=\"soft\" x=\"{LEFT}\" y=\"46\">{}</text>\n",
            escape(self.title),
            REAL[0],
            RIGHT - LEFT,
            REAL[1] - REAL[0],
            escape(self.title),
            escape(self.subtitle),
        );
        self.shade(&mut out, &x);
        panel(&mut out, &x, &real, "real part, 1/s", 6.0);
        panel(&mut out, &x, &imaginary, "imaginary part, rad/s", 4.0);
        let _ = writeln!(
            out,
            "<line class=\"zero\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
            y = real.at(0.0)
        );
        for v in ticks(low, high, 10.0) {
            let text = label(v, tick_step(high - low, 10.0));
            let _ = writeln!(
                out,
                "<text class=\"soft\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
                x.at(v),
                IMAGINARY[1] + 18.0
            );
        }
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">forward speed, m/s</text>",
            0.5 * (LEFT + RIGHT),
            IMAGINARY[1] + 40.0
        );
        // Each branch as its speed and eigenvalue, step by step.
        let branch = |b: usize| {
            let steps = speeds.iter().zip(&family).zip(&branches);
            steps
                .filter_map(move |((v, pairs), order)| Some((*v, pairs.get(*order.get(b)?)?.value)))
        };
        for b in 0..count {
            let re = path(branch(b).map(|(v, s)| Some((x.at(v), real.at(s.re)))));
            let im = path(
                branch(b).map(|(v, s)| (s.im != 0.0).then(|| (x.at(v), imaginary.at(s.im.abs())))),
            );
            let class = name(b).as_str();
            let _ = writeln!(
                out,
                "<path class=\"line {class}\" clip-path=\"url(#tm-real)\" d=\"{re}\"/>"
            );
            if !im.is_empty() {
                let _ = writeln!(out, "<path class=\"line {class}\" d=\"{im}\"/>");
            }
        }
        self.legend(&mut out);
        out.push_str("</svg>\n");
        out
    }

    fn shade(&self, out: &mut String, x: &Axis) {
        for [from, to] in &self.modes.stable_ranges_m_s {
            let (a, b) = (x.at(*from), x.at(*to));
            for [top, bottom] in [REAL, IMAGINARY] {
                let _ = writeln!(
                    out,
                    "<rect class=\"stable\" x=\"{a:.1}\" y=\"{top}\" width=\"{:.1}\" height=\"{}\"/>",
                    b - a,
                    bottom - top
                );
            }
        }
        // A mark at each crossing, its speed alternately high and low so that neighbours can be read.
        for (i, Critical { speed_m_s, .. }) in self.modes.criticals.iter().enumerate() {
            let at = x.at(*speed_m_s);
            let _ = writeln!(
                out,
                "<line class=\"mark\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{}\" y2=\"{}\"/><text class=\"soft\" x=\"{:.1}\" \
                 y=\"{}\" text-anchor=\"{}\">{speed_m_s:.2}</text>",
                REAL[0],
                IMAGINARY[1],
                if i % 2 == 0 { at - 4.0 } else { at + 4.0 },
                REAL[0] + 14.0,
                if i % 2 == 0 { "end" } else { "start" },
            );
        }
    }

    fn legend(&self, out: &mut String) {
        let mut at = LEFT;
        for name in [
            ModeName::Weave,
            ModeName::Capsize,
            ModeName::Caster,
            ModeName::Other,
        ] {
            if !self
                .modes
                .points
                .iter()
                .any(|p| p.modes.iter().any(|m| m.name == name))
            {
                continue;
            }
            let _ = writeln!(
                out,
                "<path class=\"line {name}\" d=\"M{at} 68h30\"/><text x=\"{}\" y=\"72\">{name}</text>",
                at + 38.0
            );
            at += 110.0;
        }
        if !self.modes.stable_ranges_m_s.is_empty() {
            let _ = writeln!(
                out,
                "<rect class=\"stable\" x=\"{at}\" y=\"61\" width=\"30\" height=\"14\"/><text x=\"{}\" y=\"72\">stable by itself</text>",
                at + 38.0
            );
        }
    }

    /// A page that holds nothing but the picture.
    pub fn html(&self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
             <meta name=\"color-scheme\" content=\"light dark\"><title>{}</title>\
             <style>body{{margin:2rem auto;max-width:{WIDTH}px}}</style>\n{}</html>\n",
            escape(self.title),
            self.svg()
        )
    }
}

/// Frame, grid and vertical axis of one panel.
fn panel(out: &mut String, x: &Axis, y: &Axis, title: &str, count: f64) {
    let (top, bottom) = (y.to, y.from);
    for v in ticks(x.low, x.high, 10.0) {
        let at = x.at(v);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top}\" y2=\"{bottom}\"/>"
        );
    }
    let step = tick_step(y.high - y.low, count);
    for v in ticks(y.low, y.high, count) {
        let at = y.at(v);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/><text class=\"soft\" x=\"{}\" \
             y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 8.0,
            at + 4.5,
            label(v, step)
        );
    }
    let middle = 0.5 * (top + bottom);
    let _ = writeln!(
        out,
        "<rect class=\"frame\" x=\"{LEFT}\" y=\"{top}\" width=\"{}\" height=\"{}\"/>\
         <text transform=\"translate(18 {middle}) rotate(-90)\" text-anchor=\"middle\">{title}</text>",
        RIGHT - LEFT,
        bottom - top
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinhub_linear::{Bicycle, Canonical, MotorPair};

    fn picture(title: &str) -> String {
        let bicycle = Bicycle::load("meijaard2007_benchmark").unwrap();
        let speeds: Vec<f64> = (0..=200).map(|k| 0.05 * k as f64).collect();
        let modes = Modes::over(&Canonical::new(&bicycle).unwrap(), MotorPair::OFF, &speeds);
        ModesPicture {
            title,
            subtitle: "motors off",
            modes: &modes,
        }
        .svg()
    }

    #[test]
    fn shades_where_the_benchmark_is_stable() {
        let svg = picture("benchmark");
        // 4.292 and 6.024 m/s of 0 to 10 on 676 px from 64.
        assert!(
            svg.contains("<rect class=\"stable\" x=\"354.2\" y=\"86\" width=\"117.1\""),
            "{svg}"
        );
        for text in [
            ">4.29<",
            ">6.02<",
            "real part, 1/s",
            "imaginary part, rad/s",
            "forward speed, m/s",
            ">weave<",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn text_cannot_break_out() {
        let svg = picture("<script>&\"");
        assert!(!svg.contains("<script>") && svg.contains("&lt;script&gt;&amp;&quot;"));
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(
            ticks(0.0, 10.0, 10.0),
            (0..=10).map(f64::from).collect::<Vec<_>>()
        );
        assert_eq!(label(-2.5, 0.5), "\u{2212}2.5");
        assert_eq!(tick_step(37.0, 6.0), 5.0);
    }
}
