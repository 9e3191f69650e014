//! Figures 3.4 to 3.10 and 7.3 to 7.5, drawn again with one set of assumptions for all.

use crate::assumed::{Assumed, Measured};
use crate::chapter3::{PROPERTIES, benchmark_bicycle, damped_arms, sensitivity_percent};
use crate::chapter7::{
    CORNER_M_S, Drive, HANDS_OFF_S, PUSHED_S, PairOn, STOPPED_S, TURN_S, corner, pair_weave_m_s,
    pushed,
};
use crate::error::ReproduceError;
use crate::misses::on_tyres;
use crate::motion::Trace;
use crate::push;
use twinhub_linear::ModeName;
use twinhub_plant::multibody::{Case, Course, Multibody, Parameters};
use twinhub_plant::tyre::{TyreInput, TyreModel};
use twinhub_report::reproduce::{Line, Plot, PlotPanel};

type Drawn = Result<Plot, ReproduceError>;

/// Weave and capsize over speed; NaN where there is none.
struct Curves {
    speeds: Vec<f64>,
    weave_re: Vec<f64>,
    weave_im: Vec<f64>,
    capsize_re: Vec<f64>,
}

fn curves(p: &Parameters, from_m_s: f64) -> Result<Curves, ReproduceError> {
    let steps = libm::round((11.0 - from_m_s) / 0.25) as usize;
    let speeds: Vec<f64> = (0..=steps).map(|k| from_m_s + 0.25 * k as f64).collect();
    let sweep = Multibody::new(p)?.sweep(&Course::straight(5.0), &speeds)?;
    let of = |mode: ModeName, part: &dyn Fn(nalgebra::Complex<f64>) -> f64| -> Vec<f64> {
        let branches: Vec<usize> = (0..sweep.names.len())
            .filter(|&b| sweep.names[b] == mode)
            .collect();
        sweep
            .points
            .iter()
            .map(|at| {
                branches
                    .iter()
                    .map(|&b| part(at.modes[b].value))
                    .reduce(f64::max)
                    .unwrap_or(f64::NAN)
            })
            .collect()
    };
    Ok(Curves {
        weave_re: of(ModeName::Weave, &|z| z.re),
        weave_im: of(ModeName::Weave, &|z| z.im.abs()),
        capsize_re: of(ModeName::Capsize, &|z| z.re),
        speeds,
    })
}

fn line(name: &str, style: usize, x: &[f64], y: &[f64]) -> Line {
    Line {
        name: name.to_owned(),
        style,
        x: x.to_vec(),
        y: y.to_vec(),
    }
}

fn panel(title: &str, unit: &str, lines: Vec<Line>) -> PlotPanel {
    PlotPanel {
        title: title.to_owned(),
        unit: unit.to_owned(),
        lines,
        levels: Vec::new(),
    }
}

/// Weave of several bicycles: real and imaginary parts.
fn weave_plot(
    name: &str,
    title: &str,
    note: &str,
    marks: &[(f64, &str)],
    bicycles: &[(&str, Parameters)],
) -> Drawn {
    let mut panels = [
        panel("weave, real part", "1/s", Vec::new()),
        panel("weave, imaginary part", "rad/s", Vec::new()),
    ];
    for (style, (name, p)) in bicycles.iter().enumerate() {
        let c = curves(p, 3.0)?;
        panels[0]
            .lines
            .push(line(name, style, &c.speeds, &c.weave_re));
        panels[1]
            .lines
            .push(line(name, style, &c.speeds, &c.weave_im));
    }
    Ok(Plot {
        name: name.to_owned(),
        title: title.to_owned(),
        note: note.to_owned(),
        x_title: "forward speed, m/s".to_owned(),
        panels: panels.to_vec(),
        marks: marks.iter().map(|(v, n)| (*v, (*n).to_owned())).collect(),
        ..Plot::default()
    })
}

fn figure_3_4(assumed: &Assumed) -> Drawn {
    let bicycles = [
        ("no slip", benchmark_bicycle(assumed, false)?),
        ("Magic Formula", benchmark_bicycle(assumed, true)?),
    ];
    let mut plot = weave_plot(
        "figure_3_4",
        "Figure 3.4: the benchmark bicycle",
        "Marks: weave speeds of the thesis, 4.29 m/s without slip and 7.4 m/s on tyres, and the capsize speed of the benchmark. Dotted: four poles fitted to the response to a push.",
        &[
            (4.292, "weave 4.29"),
            (6.024, "capsize 6.02"),
            (7.4, "weave on tyres 7.4"),
        ],
        &bicycles,
    )?;
    let mut capsize = panel("capsize, real part", "1/s", Vec::new());
    for (style, (name, p)) in bicycles.iter().enumerate() {
        let c = curves(p, 3.0)?;
        capsize
            .lines
            .push(line(name, style, &c.speeds, &c.capsize_re));
        let speeds: Vec<f64> = (4..=10).map(f64::from).collect();
        let fitted: Vec<_> = speeds
            .iter()
            .map(|&v| push::weave(p, &Course::straight(v)).ok().flatten())
            .collect();
        let part = |f: &dyn Fn(nalgebra::Complex<f64>) -> f64| -> Vec<f64> {
            fitted.iter().map(|w| w.map_or(f64::NAN, f)).collect()
        };
        let name = format!("{name}, four poles");
        plot.panels[0]
            .lines
            .push(line(&name, 3, &speeds, &part(&|w| w.re)));
        plot.panels[1]
            .lines
            .push(line(&name, 3, &speeds, &part(&|w| w.im)));
    }
    plot.panels.push(capsize);
    Ok(plot)
}

fn figure_3_5(assumed: &Assumed) -> Drawn {
    let names = ["1", "2", "3", "4", "5", "6", "7"].map(|n| format!("case {n}"));
    let bicycles: Vec<(&str, Parameters)> = names
        .iter()
        .zip(Case::ALL)
        .map(|(name, case)| (name.as_str(), assumed.case(case)))
        .collect();
    let mut plot = weave_plot(
        "figure_3_5",
        "Figure 3.5: cases 1 to 7",
        "No slip: 1 rigid rider, 2 passive rider, 3 arm mass, 4 arm damping, 5 arm stiffness. On tyres: 6 rigid rider, 7 everything. Marks: the thesis's weave speeds of cases 1 and 6 and capsize speed of case 1.",
        &[
            (4.9, "case 1 weave 4.9"),
            (6.8, "case 1 capsize 6.8"),
            (9.3, "case 6 weave 9.3"),
        ],
        &bicycles,
    )?;
    let mut capsize = panel("capsize, real part", "1/s", Vec::new());
    for (style, (name, p)) in bicycles.iter().enumerate() {
        let c = curves(p, 3.0)?;
        capsize
            .lines
            .push(line(name, style, &c.speeds, &c.capsize_re));
    }
    plot.panels.push(capsize);
    Ok(plot)
}

fn figure_3_6(assumed: &Assumed) -> Drawn {
    let on = |measured| {
        let mut p = assumed.case(Case::Full);
        assumed.fit_tyres(&mut p, measured, &|_| {});
        p
    };
    weave_plot(
        "figure_3_6",
        "Figure 3.6: tyres measured at 400 N and at 600 N",
        "Case 7. Marks: the thesis's weave speeds. What was measured at 600 N is not published; ours is table A3 taken there by its own load dependence.",
        &[(8.3, "600 N 8.3"), (9.7, "400 N 9.7")],
        &[
            ("400 N", on(Measured::At400N)),
            ("600 N", on(Measured::At600N)),
        ],
    )
}

fn figure_3_7(assumed: &Assumed) -> Drawn {
    let p = assumed.case(Case::Full);
    let factors = [0.5, 0.75, 1.0, 1.5, 2.0];
    let lines = PROPERTIES
        .iter()
        .enumerate()
        .map(|(k, (name, _))| {
            let y: Vec<f64> = factors
                .iter()
                .map(|&f| sensitivity_percent(&p, k, f).unwrap_or(f64::NAN))
                .collect();
            line(name, k, &factors, &y)
        })
        .collect();
    Ok(Plot {
        name: "figure_3_7".to_owned(),
        title: "Figure 3.7: weave speed against the tyre's properties".to_owned(),
        note: "Case 7, one property of both tyres scaled at a time. The thesis at twice the value: cornering stiffness under -1 %, camber +9 %, twisting +25 %, trail +4 %, overturning -3 %.".to_owned(),
        x_title: "property over that of table A3".to_owned(),
        panels: vec![panel("change of weave speed", "%", lines)],
        ..Plot::default()
    })
}

fn figure_3_8(assumed: &Assumed) -> Result<[Plot; 2], ReproduceError> {
    let scaled = |factor: f64| {
        let mut p = assumed.case(Case::Full);
        on_tyres(&mut p, &|t| t.twisting_gain *= factor);
        p
    };
    let factors = [
        ("0 %", 0.0),
        ("10 %", 0.1),
        ("50 %", 0.5),
        ("100 %", 1.0),
        ("150 %", 1.5),
        ("200 %", 2.0),
    ];
    let bicycles: Vec<(&str, Parameters)> = factors.iter().map(|(n, f)| (*n, scaled(*f))).collect();
    let a = weave_plot(
        "figure_3_8a",
        "Figure 3.8a: weave against the twisting torque",
        "Case 7, twisting torque of both tyres as a share of table A3's.",
        &[],
        &bicycles,
    )?;
    let slips: Vec<f64> = (-60..=60).map(|k| 0.002 * f64::from(k)).collect();
    let panels = [("10 %", 0.1), ("100 %", 1.0), ("200 %", 2.0)]
        .iter()
        .map(|(name, factor)| {
            let tyre = scaled(*factor).tyre.front;
            let lines = [0.0, 0.07, 0.17]
                .iter()
                .enumerate()
                .map(|(style, &camber_rad)| {
                    let y: Vec<f64> = slips
                        .iter()
                        .map(|&slip_angle_rad| {
                            tyre.output(&TyreInput {
                                load_n: 400.0,
                                slip_ratio: 0.0,
                                slip_angle_rad,
                                camber_rad,
                                speed_m_s: 5.0,
                                friction_ratio: 1.0,
                                radius_m: 0.35,
                            })
                            .aligning_nm
                        })
                        .collect();
                    line(&format!("camber {camber_rad} rad"), style, &slips, &y)
                })
                .collect();
            panel(&format!("yaw torque, twisting {name}"), "Nm", lines)
        })
        .collect();
    let b = Plot {
        name: "figure_3_8b".to_owned(),
        title: "Figure 3.8b: yaw torque against side slip and camber".to_owned(),
        note: "Self-aligning plus twisting torque at 400 N; slip angle positive when the contact slides to the right, camber to the right, torque that turns the wheel right.".to_owned(),
        x_title: "slip angle, rad".to_owned(),
        panels,
        ..Plot::default()
    };
    Ok([a, b])
}

fn figure_3_9(assumed: &Assumed) -> Drawn {
    let mut capsize = panel("capsize, real part", "1/s", Vec::new());
    for (style, stiffness) in [0.0, 3.2, 5.0, 10.0, 20.0].into_iter().enumerate() {
        let mut p = damped_arms(assumed, 0.0);
        p.arms.torsional_stiffness_nm_rad = stiffness;
        let c = curves(&p, 3.0)?;
        capsize.lines.push(line(
            &format!("{stiffness} Nm/rad"),
            style,
            &c.speeds,
            &c.capsize_re,
        ));
    }
    capsize.levels.push((0.0, String::new()));
    Ok(Plot {
        name: "figure_3_9".to_owned(),
        title: "Figure 3.9: arm stiffness and capsize on tyres".to_owned(),
        note: "Case 7 without arm damping. In the thesis the tyres make capsize stable again above a speed that rises with arm stiffness.".to_owned(),
        x_title: "forward speed, m/s".to_owned(),
        panels: vec![capsize],
        ..Plot::default()
    })
}

fn figure_3_10(assumed: &Assumed) -> Drawn {
    let dampings = [0.0, 0.9, 2.0, 4.0, 8.0, 12.0];
    let names = dampings.map(|d| format!("{d} Nm s/rad"));
    let bicycles: Vec<(&str, Parameters)> = names
        .iter()
        .zip(dampings)
        .map(|(name, d)| (name.as_str(), damped_arms(assumed, d)))
        .collect();
    weave_plot(
        "figure_3_10",
        "Figure 3.10: arm damping and weave on tyres",
        "Case 7 without arm stiffness. Mark: the highest weave speed of the thesis, for damping much larger than 0.9 Nm s/rad.",
        &[(11.5, "11.5")],
        &bicycles,
    )
}

const DEGREE: f64 = core::f64::consts::PI / 180.0;

/// Time signals of runs, in degrees.
fn signals(
    title: &str,
    unit: &str,
    runs: &[(&str, &Trace)],
    of: impl Fn(&Trace) -> Vec<f64>,
) -> PlotPanel {
    let lines = runs
        .iter()
        .enumerate()
        .map(|(k, (name, t))| line(name, k, &t.t_s, &of(t)))
        .collect();
    panel(title, unit, lines)
}

fn degrees(v: &[f64]) -> Vec<f64> {
    // A fall is a fall: beyond 60 degrees nothing is drawn.
    v.iter()
        .map(|r| r / DEGREE)
        .map(|d| if d.abs() > 60.0 { f64::NAN } else { d })
        .collect()
}

fn figure_7_3(assumed: &Assumed) -> Drawn {
    let p = assumed.chapter7();
    let run = |drive| corner(&p, drive, CORNER_M_S);
    let (none, front, rear) = (run(Drive::None)?, run(Drive::Front)?, run(Drive::Rear)?);
    let runs = [
        ("no motor", &none),
        ("front 80 Nm", &front),
        ("rear 80 Nm", &rear),
    ];
    Ok(Plot {
        name: "figure_7_3".to_owned(),
        title: "Figure 7.3: a corner, then hands off".to_owned(),
        note: format!(
            "Case 7, corner at {CORNER_M_S} m/s (a guess: the thesis does not print speed and gains), hands off and 80 Nm at 7.5 s. In the thesis the bicycle is unstable without motor, still unstable with the front motor, and settles with the rear one."
        ),
        x_title: "time, s".to_owned(),
        panels: vec![
            signals("steer torque", "Nm", &runs, |t| {
                t.steer_torque_nm
                    .iter()
                    .map(|v| v.clamp(-10.0, 10.0))
                    .collect()
            }),
            signals("steer", "°", &runs, |t| degrees(&t.steer_rad)),
            signals("roll", "°", &runs, |t| degrees(&t.roll_rad)),
            signals("heading", "°", &runs, |t| {
                t.yaw_rad.iter().map(|r| r / DEGREE).collect()
            }),
            signals("speed", "m/s", &runs, |t| t.speed_m_s.clone()),
        ],
        marks: vec![
            (TURN_S, "turn in".to_owned()),
            (HANDS_OFF_S, "hands off".to_owned()),
        ],
        ..Plot::default()
    })
}

fn figure_7_4(assumed: &Assumed) -> Drawn {
    let p = assumed.chapter7();
    let run = |on| pushed(&p, on, 80.0);
    let (never, between, always) = (
        run(PairOn::Never)?,
        run(PairOn::Between)?,
        run(PairOn::Always)?,
    );
    let runs = [
        ("no pair", &never),
        ("80 Nm from 15 to 20 s", &between),
        ("80 Nm throughout", &always),
    ];
    Ok(Plot {
        name: "figure_7_4".to_owned(),
        title: "Figure 7.4: a push at 7 m/s".to_owned(),
        note: "Case 7. In the thesis unstable without the pair, stable with 80 Nm, unstable again when it is switched off.".to_owned(),
        x_title: "time, s".to_owned(),
        panels: vec![
            signals("roll", "°", &runs, |t| degrees(&t.roll_rad)),
            signals("steer", "°", &runs, |t| degrees(&t.steer_rad)),
        ],
        marks: vec![(PUSHED_S, "push".to_owned()), (STOPPED_S, "off in the second run".to_owned())],
        ..Plot::default()
    })
}

fn figure_7_5(assumed: &Assumed) -> Drawn {
    let p = assumed.chapter7();
    let torques: Vec<f64> = (0..=10).map(|k| 10.0 * f64::from(k)).collect();
    let speeds: Vec<f64> = torques
        .iter()
        .map(|&t| pair_weave_m_s(&p, t).unwrap_or(f64::NAN))
        .collect();
    let start = speeds[0];
    let straight: Vec<f64> = torques.iter().map(|t| start * (1.0 - 0.0023 * t)).collect();
    Ok(Plot {
        name: "figure_7_5".to_owned(),
        title: "Figure 7.5: weave speed against the torque of the pair".to_owned(),
        note: "Case 7. The thesis: near linear, almost -23 % at 100 Nm; drawn as a straight line from our weave speed at 0 Nm.".to_owned(),
        x_title: "torque of the pair, Nm".to_owned(),
        panels: vec![panel(
            "weave speed",
            "m/s",
            vec![line("ours", 0, &torques, &speeds), line("-23 % at 100 Nm", 2, &torques, &straight)],
        )],
        ..Plot::default()
    })
}

/// All figures, in the order of the source. `progress` is told after each how many are done, and of
/// how many.
pub fn all(
    assumed: &Assumed,
    progress: &dyn Fn(usize, usize),
) -> Result<Vec<Plot>, ReproduceError> {
    let single: [fn(&Assumed) -> Drawn; 9] = [
        figure_3_4,
        figure_3_5,
        figure_3_6,
        figure_3_7,
        figure_3_9,
        figure_3_10,
        figure_7_3,
        figure_7_4,
        figure_7_5,
    ];
    let mut plots = Vec::new();
    for (k, draw) in single.iter().enumerate() {
        plots.push(draw(assumed)?);
        progress(k + 1, single.len() + 1);
    }
    plots.extend(figure_3_8(assumed)?);
    plots.sort_by_key(|p| order(&p.name));
    progress(single.len() + 1, single.len() + 1);
    Ok(plots)
}

/// Chapter, number and letter of a name like `figure_3_10`.
fn order(name: &str) -> (u32, u32, String) {
    let mut parts = name.split('_').skip(1);
    let chapter = parts.next().and_then(|c| c.parse().ok()).unwrap_or(0);
    let rest = parts.next().unwrap_or("");
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    (
        chapter,
        digits.parse().unwrap_or(0),
        rest[digits.len()..].to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn figures_come_in_the_order_of_the_source() {
        let mut names = [
            "figure_7_3",
            "figure_3_10",
            "figure_3_8b",
            "figure_3_8a",
            "figure_3_9",
        ];
        names.sort_by_key(|n| order(n));
        assert_eq!(
            names,
            [
                "figure_3_8a",
                "figure_3_8b",
                "figure_3_9",
                "figure_3_10",
                "figure_7_3"
            ]
        );
    }
}
