//! What every tyre must do, run over every set that ships and over the options of each model.

use super::{
    Combined, Friction, LateralForm, SETS, Tyre, TyreInput, TyreModel, TyreOutput, explain, set,
};
use crate::tyre::dual::Dual;

/// Every set, and each model's sets with every option that is not on by default.
fn tyres() -> Vec<(String, Tyre)> {
    let mut all: Vec<(String, Tyre)> = Vec::new();
    for set in SETS {
        all.push((set.name.to_string(), set.tyre));
        for friction in [Friction::AsFile, Friction::Absolute] {
            for combined in [Combined::None, Combined::Ellipse] {
                let name = format!("{} {friction:?} {combined:?}", set.name);
                match set.tyre {
                    Tyre::MagicFormula(mut tyre) => {
                        (tyre.friction, tyre.combined) = (friction, combined);
                        tyre.load_range_n = tyre.frozen_load_n.is_none().then_some([200.0, 700.0]);
                        for form in [
                            LateralForm::Motorcycle,
                            LateralForm::Saturating,
                            LateralForm::AsPrinted,
                        ] {
                            tyre.lateral_form = form;
                            all.push((format!("{name} {form:?}"), Tyre::MagicFormula(tyre)));
                        }
                    }
                    Tyre::MagicFormula1989(mut tyre) => {
                        (tyre.friction, tyre.combined) = (friction, combined);
                        all.push((name, Tyre::MagicFormula1989(tyre)));
                    }
                    Tyre::Linear(_) | Tyre::NoSlip(_) => {}
                }
            }
        }
    }
    assert!(
        Tyre::NAMES
            .iter()
            .all(|name| all.iter().any(|(_, tyre)| tyre.name() == *name))
    );
    all
}

fn at(load_n: f64, slip_ratio: f64, slip_angle_rad: f64, camber_rad: f64) -> TyreInput<f64> {
    TyreInput {
        load_n,
        slip_ratio,
        slip_angle_rad,
        camber_rad,
        speed_m_s: 5.0,
        friction_ratio: 1.0,
        radius_m: 0.35,
    }
}

/// Inputs over the whole range of riding, each with its mirror image among them.
fn riding() -> Vec<TyreInput<f64>> {
    let mut inputs = Vec::new();
    for load in [20.0, 150.0, 400.0, 650.0] {
        for kappa in [-1.0, -0.05, 0.0, 0.02, 0.6] {
            for alpha in [-1.2, -0.1, -0.01, 0.0, 0.03, 0.2] {
                for gamma in [-0.6, -0.1, 0.0, 0.05, 0.4] {
                    for friction_ratio in [0.2, 1.0] {
                        inputs.push(TyreInput {
                            friction_ratio,
                            ..at(load, kappa, alpha, gamma)
                        });
                    }
                }
            }
        }
    }
    inputs
}

fn parts<T>(out: TyreOutput<T>) -> [T; 5] {
    [
        out.longitudinal_n,
        out.lateral_n,
        out.overturning_nm,
        out.rolling_resistance_nm,
        out.aligning_nm,
    ]
}

#[test]
fn without_slip_and_upright_only_rolling_resistance_is_left() {
    for (name, tyre) in tyres() {
        for load in [0.0, 1.0, 400.0, 900.0] {
            let out = tyre.output(&at(load, 0.0, 0.0, 0.0));
            let [x, y, over, rolling, z] = parts(out);
            assert_eq!(
                [x, y, over, z].map(f64::abs),
                [0.0; 4],
                "{name} at {load} N: {out:?}"
            );
            assert!(
                rolling >= 0.0 && rolling <= 0.02 * load,
                "{name}: {rolling}"
            );
        }
    }
}

#[test]
fn offsets_of_the_1989_formula_show_only_when_kept() {
    let Tyre::MagicFormula1989(mut tyre) = set("magic_formula_1989").unwrap().tyre else {
        panic!()
    };
    tyre.remove_offsets = false;
    assert!(tyre.output(&at(400.0, 0.0, 0.0, 0.0)).lateral_n.abs() > 1.0);
    assert_eq!(
        tyre.output(&at(0.0, 0.0, 0.1, 0.1)).lateral_n,
        0.0,
        "no load, no force"
    );
}

#[test]
fn the_mirror_image_of_a_contact_has_the_mirror_image_of_its_forces() {
    for (name, tyre) in tyres() {
        for input in riding() {
            let mirror = TyreInput {
                slip_angle_rad: -input.slip_angle_rad,
                camber_rad: -input.camber_rad,
                ..input
            };
            let [x, y, over, rolling, z] = parts(tyre.output(&input));
            let mirrored = parts(tyre.output(&mirror));
            for (a, b) in [x, -y, -over, rolling, -z].iter().zip(mirrored) {
                assert!(
                    (a - b).abs() <= 1e-12 * (1.0 + a.abs()),
                    "{name}: {a} {b} at {input:?}"
                );
            }
        }
    }
}

#[test]
fn an_upright_tyre_takes_energy_out_and_never_gives_any() {
    for (name, tyre) in tyres() {
        for input in riding().into_iter().filter(|input| input.camber_rad == 0.0) {
            for speed_m_s in [-4.0, 0.0, 6.0] {
                let input = TyreInput { speed_m_s, ..input };
                let [x, y, _, rolling, _] = parts(tyre.output(&input));
                // velocity of the sliding tread is |v_x| (-κ, tan α)
                let sliding = -x * input.slip_ratio + y * input.slip_angle_rad.tan();
                assert!(sliding <= 1e-9, "{name}: {sliding} W per m/s at {input:?}");
                assert!(
                    rolling * speed_m_s >= 0.0,
                    "{name}: rolling drives at {speed_m_s}"
                );
            }
        }
    }
}

#[test]
fn with_ellipse_and_road_friction_no_force_passes_the_friction_limit() {
    let mut tested = 0;
    for (name, tyre) in tyres() {
        let limited = match tyre {
            Tyre::MagicFormula(t) => {
                t.friction == Friction::Absolute && t.combined == Combined::Ellipse
            }
            _ => false,
        };
        if limited {
            for input in riding() {
                let [x, y, ..] = parts(tyre.output(&input));
                let limit = input.friction_ratio * input.load_n;
                assert!(
                    x.hypot(y) <= limit * (1.0 + 1e-12),
                    "{name}: {x} {y} over {limit}"
                );
                tested += 1;
            }
        }
    }
    assert!(tested > 0);
}

/// With combined slip a wheel that slides along has hardly any side force and yaw torque left.
#[test]
fn with_the_ellipse_a_locked_wheel_neither_holds_nor_steers() {
    let mut tested = 0;
    for (name, tyre) in tyres() {
        let combined = match tyre {
            Tyre::MagicFormula(t) => t.combined,
            Tyre::MagicFormula1989(t) => t.combined,
            _ => Combined::None,
        };
        if combined == Combined::Ellipse {
            let rolling = tyre.output(&at(400.0, 0.0, 0.03, 0.1));
            let locked = tyre.output(&at(400.0, -1.0, 0.03, 0.1));
            for (what, before, after) in [
                ("side force", rolling.lateral_n, locked.lateral_n),
                ("yaw torque", rolling.aligning_nm, locked.aligning_nm),
            ] {
                assert!(
                    after.abs() < 0.15 * before.abs(),
                    "{name}: {what} {after}, rolling {before}"
                );
            }
            tested += 1;
        }
    }
    assert!(tested > 2);
}

#[test]
fn friction_of_the_road_limits_forces_and_leaves_slopes() {
    for (name, tyre) in tyres()
        .into_iter()
        .filter(|(_, t)| !matches!(t, Tyre::NoSlip(_)))
    {
        let slope = |friction_ratio: f64| {
            let input = |h: f64| TyreInput {
                friction_ratio,
                ..at(400.0, h, h, 0.0)
            };
            let (up, down) = (tyre.output(&input(1e-6)), tyre.output(&input(-1e-6)));
            [
                up.longitudinal_n - down.longitudinal_n,
                up.lateral_n - down.lateral_n,
            ]
        };
        for (dry, ice) in slope(1.0).into_iter().zip(slope(0.2)) {
            assert!(
                (dry / ice - 1.0).abs() < 1e-6,
                "{name}: slope {dry} and {ice}"
            );
        }
        if !matches!(tyre, Tyre::Linear(_)) {
            let peak = |friction_ratio: f64| {
                tyre.output(&TyreInput {
                    friction_ratio,
                    ..at(400.0, 0.0, 0.15, 0.0)
                })
                .lateral_n
            };
            assert!(
                peak(0.2) / peak(1.0) < 0.35,
                "{name}: ice holds {}",
                peak(0.2)
            );
        }
    }
}

#[test]
fn no_load_no_force_and_force_comes_back_with_load() {
    for (name, tyre) in tyres() {
        for load in [0.0, -0.0, -1.0, -1e6, f64::MIN] {
            let out = parts(tyre.output(&at(load, 0.3, 0.2, 0.3)));
            assert_eq!(out.map(f64::abs), [0.0; 5], "{name} at {load} N");
        }
        let out = parts(tyre.output(&at(1e-6, 0.3, 0.2, 0.3)));
        assert!(
            out.iter().all(|part| part.abs() < 1e-4),
            "{name}: {out:?} at 1e-6 N"
        );
    }
}

#[test]
fn finite_input_gives_finite_output() {
    let extremes = [-1e200, -1e8, -3.2, -1e-300, 0.0, 1e-9, 1.6, 1e8, 1e200];
    for (name, tyre) in tyres() {
        for load in [-1e300, 0.0, 1e-300, 1.0, 1e5, 1e300] {
            for kappa in extremes {
                for alpha in extremes {
                    for gamma in extremes {
                        for friction_ratio in [-1.0, 0.0, 1e-12, 1.0, 1e6] {
                            let input = TyreInput {
                                friction_ratio,
                                speed_m_s: kappa,
                                ..at(load, kappa, alpha, gamma)
                            };
                            let out = parts(tyre.output(&input));
                            assert!(
                                out.iter().all(|o| o.is_finite()),
                                "{name} {input:?} {out:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn derivatives_by_dual_numbers_agree_with_differences() {
    let points = [
        at(400.0, 0.01, 0.02, 0.05),
        at(310.0, -0.04, -0.07, 0.1),
        at(620.0, 0.1, 0.05, -0.2),
        TyreInput {
            friction_ratio: 0.4,
            ..at(250.0, -0.2, 0.11, 0.15)
        },
    ];
    for (name, tyre) in tyres() {
        for point in points {
            for which in 0..6 {
                let seed = |i: usize, value: f64| Dual(value, f64::from(u8::from(i == which)));
                let dual = parts(tyre.output(&TyreInput {
                    load_n: seed(0, point.load_n),
                    slip_ratio: seed(1, point.slip_ratio),
                    slip_angle_rad: seed(2, point.slip_angle_rad),
                    camber_rad: seed(3, point.camber_rad),
                    speed_m_s: seed(4, point.speed_m_s),
                    friction_ratio: seed(5, point.friction_ratio),
                    radius_m: point.radius_m,
                }));
                let shifted = |h: f64| {
                    let mut input = point;
                    match which {
                        0 => input.load_n += h,
                        1 => input.slip_ratio += h,
                        2 => input.slip_angle_rad += h,
                        3 => input.camber_rad += h,
                        4 => input.speed_m_s += h,
                        _ => input.friction_ratio += h,
                    }
                    parts(tyre.output(&input))
                };
                if which == 1 {
                    let told = tyre.output(&point).longitudinal_stiffness_n;
                    assert!(
                        (told - dual[0].1).abs() <= 1e-12 * (1.0 + told.abs()),
                        "{name}: longitudinal stiffness {told}, derivative {}",
                        dual[0].1
                    );
                }
                let h = if which == 0 { 1e-2 } else { 1e-6 };
                let (up, down) = (shifted(h), shifted(-h));
                let value = parts(tyre.output(&point));
                for part in 0..5 {
                    assert_eq!(
                        dual[part].0, value[part],
                        "{name}: value through dual numbers"
                    );
                    let slope = (up[part] - down[part]) / (2.0 * h);
                    let tolerance = 2e-6 * (1.0 + slope.abs() + value[part].abs());
                    let found = dual[part].1;
                    assert!(
                        (found - slope).abs() < tolerance,
                        "{name}: part {part} by input {which}: dual {found}, difference {slope}"
                    );
                }
            }
        }
    }
}

#[test]
fn toml_goes_round_and_typos_are_refused_with_their_line() {
    for (name, tyre) in tyres() {
        tyre.validate()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let text = toml::to_string(&tyre).unwrap();
        assert_eq!(
            toml::from_str::<Tyre>(&text).unwrap(),
            tyre,
            "{name}\n{text}"
        );
        let typo = text.replacen("]\n", "]\nlaod_n = 3.0\n", 1);
        let error = toml::from_str::<Tyre>(&typo).unwrap_err().to_string();
        assert!(
            error.contains("line 2") && error.contains("laod_n"),
            "{name}: {error}"
        );
    }
}

#[test]
fn a_set_that_no_tyre_can_have_is_refused_by_name() {
    let Tyre::MagicFormula(good) = set("bulsink2017").unwrap().tyre else {
        panic!()
    };
    let bad = [
        (
            super::MagicFormula {
                nominal_load_n: 0.0,
                ..good
            },
            "nominal_load_n",
        ),
        (
            super::MagicFormula {
                nominal_load_n: f64::NAN,
                ..good
            },
            "nominal_load_n",
        ),
        (
            super::MagicFormula {
                cornering_max_per_rad: 16.07,
                ..good
            },
            "cornering_max_per_rad",
        ),
        (
            super::MagicFormula {
                twisting_gain: -1.0,
                ..good
            },
            "twisting_gain",
        ),
        (
            super::MagicFormula {
                slip_shape_ratio: 0.0,
                ..good
            },
            "slip_shape_ratio",
        ),
        (
            super::MagicFormula {
                load_range_n: Some([600.0, 400.0]),
                ..good
            },
            "load_range_n[1]",
        ),
        (
            super::MagicFormula {
                frozen_load_n: Some(400.0),
                load_range_n: Some([1.0, 2.0]),
                ..good
            },
            "frozen_load_n",
        ),
    ];
    for (tyre, parameter) in bad {
        let error = tyre.validate().unwrap_err().to_string();
        assert!(error.contains(parameter), "{error}");
    }
}

#[test]
fn every_name_has_a_set_and_an_explanation() {
    for name in Tyre::NAMES {
        let found = set(name).unwrap_or_else(|| panic!("{name} has no set"));
        assert_eq!(found.tyre.name(), *name);
        assert_eq!(explain(name).unwrap().name, *name);
    }
    for (i, one) in SETS.iter().enumerate() {
        assert!(explain(one.name).unwrap().is_complete(), "{}", one.name);
        assert!(
            SETS[i + 1..].iter().all(|other| other.name != one.name),
            "{} twice",
            one.name
        );
    }
    assert!(set("bulsink").is_none() && explain("bulsink").is_none());
}
