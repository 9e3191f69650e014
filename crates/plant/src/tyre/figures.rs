//! Figures worked out from the sources apart from our code.

use super::{LateralForm, Tyre, TyreInput, TyreModel, set};

const RADIUS_M: f64 = 0.35;

fn at(load_n: f64) -> TyreInput<f64> {
    TyreInput {
        load_n,
        slip_ratio: 0.0,
        slip_angle_rad: 0.0,
        camber_rad: 0.0,
        speed_m_s: 5.0,
        friction_ratio: 1.0,
        radius_m: RADIUS_M,
    }
}

fn near(what: &str, found: f64, expected: f64, relative: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(
        error <= relative,
        "{what}: {found}, expected {expected}, off by {error:.1e}"
    );
}

/// Slopes at the origin: longitudinal, cornering, camber stiffness, self-aligning and twisting
/// moment, overturning moment, and the rolling resistance, at `load_n`.
fn slopes(name: &str, load_n: f64) -> [f64; 7] {
    let tyre = set(name).unwrap().tyre;
    let h = 1e-5;
    let slip = tyre.output(&TyreInput {
        slip_ratio: h,
        ..at(load_n)
    });
    let side = tyre.output(&TyreInput {
        slip_angle_rad: h,
        ..at(load_n)
    });
    let lean = tyre.output(&TyreInput {
        camber_rad: h,
        ..at(load_n)
    });
    [
        slip.longitudinal_n / h,
        side.lateral_n / h,
        lean.lateral_n / h,
        side.aligning_nm / h,
        lean.aligning_nm / h,
        lean.overturning_nm / h,
        tyre.output(&at(load_n)).rolling_resistance_nm,
    ]
}

/// Table A3 by hand, wheel radius 0.35 m, in the contact frame (z down). At 400 N, df = 0:
/// Kκ = 12 x 400; Kα = 16.07 x 400 / √(1 + 1.011²) = 6428 x 0.70322845; Kγ = 1.444 x 400;
/// t = 0.35 x 0.054 = 0.0189 m, times Kα; twisting 400 x 0.35 x 0.134; overturning
/// -400 x 0.35 x 0.053; rolling resistance 400 x 0.35 x 0.008.
/// At 600 N, df = 0.5: Kα = 6428 x 1.5 / √(1.5² + 1.011²) = 6428 x 0.82923301;
/// Kγ = 600 x (1.444 + 0.255); t = 1.5 x 0.35 x (0.054 - 0.0215) = 0.0170625 m; twisting
/// 600 x 0.35 x (0.134 - 0.042).
#[test]
fn slopes_of_table_a3_as_worked_by_hand() {
    let k400 = 4_520.352_455;
    let k600 = 5_330.309_781;
    let expected400 = [4800.0, -k400, 577.6, 0.0189 * k400, 18.76, -7.42, 1.12];
    let expected600 = [
        7200.0,
        -k600,
        1019.4,
        0.017_062_5 * k600,
        19.32,
        -11.13,
        1.68,
    ];
    let cases = [
        ("bulsink2017", 400.0, expected400),
        ("bulsink2017", 600.0, expected600),
        ("bulsink2017_400n", 400.0, expected400),
        // frozen: in proportion to load
        ("bulsink2017_400n", 200.0, expected400.map(|v| 0.5 * v)),
        ("bulsink2017_600n", 300.0, expected600.map(|v| 0.5 * v)),
        ("bulsink2017_ellipse", 400.0, expected400),
        ("bulsink2017_linear", 400.0, expected400),
    ];
    for (name, load_n, expected) in cases {
        for (i, (found, expected)) in slopes(name, load_n).into_iter().zip(expected).enumerate() {
            // the trail bell loses (Bt α)² / 2 = 3e-7 at α = 1e-5
            near(
                &format!("{name} at {load_n} N, slope {i}"),
                found,
                expected,
                1e-6,
            );
        }
    }
}

/// Far from the origin, at 400 N: α = 0.05, γ = 0.2 on the right (contact frame), κ = -0.1.
/// Evaluated with Python's `math` module from A2.1 to A2.17 in ISO axes, α, Fy and Tz turned over
/// by hand.
#[test]
fn forces_of_table_a3_far_from_the_origin() {
    let input = TyreInput {
        slip_ratio: -0.1,
        slip_angle_rad: 0.05,
        camber_rad: 0.2,
        ..at(400.0)
    };
    let tyre = set("bulsink2017").unwrap().tyre;
    let out = tyre.output(&input);
    near("Fx", out.longitudinal_n, EXPECTED[0], 1e-12);
    near("Fy", out.lateral_n, EXPECTED[1], 1e-12);
    near("Tz", out.aligning_nm, EXPECTED[2], 1e-12);
    let Tyre::MagicFormula(mut tyre) = tyre else {
        panic!()
    };
    tyre.lateral_form = LateralForm::AsPrinted;
    let out = tyre.output(&input);
    near("Fy as printed", out.lateral_n, EXPECTED[3], 1e-12);
    near("Tz as printed", out.aligning_nm, EXPECTED[4], 1e-12);
}
const EXPECTED: [f64; 5] = [
    -387.5390898753798,
    -102.74854583172764,
    4.810624112599103,
    -99.41089902358779,
    4.792067420159755,
];

/// Each gain scales its own slope and no other.
#[test]
fn each_gain_scales_its_own_slope_alone() {
    let Tyre::MagicFormula(tyre) = set("bulsink2017").unwrap().tyre else {
        panic!()
    };
    let slopes = |tyre: super::MagicFormula| {
        let h = 1e-6;
        let slip = tyre.output(&TyreInput {
            slip_ratio: h,
            ..at(500.0)
        });
        let side = tyre.output(&TyreInput {
            slip_angle_rad: h,
            ..at(500.0)
        });
        let lean = tyre.output(&TyreInput {
            camber_rad: h,
            ..at(500.0)
        });
        [
            slip.longitudinal_n,
            side.lateral_n,
            lean.lateral_n,
            side.aligning_nm / side.lateral_n,
            lean.aligning_nm,
            lean.overturning_nm,
        ]
    };
    let scaled = [
        super::MagicFormula {
            longitudinal_gain: 2.0,
            ..tyre
        },
        super::MagicFormula {
            cornering_gain: 2.0,
            ..tyre
        },
        super::MagicFormula {
            camber_gain: 2.0,
            ..tyre
        },
        super::MagicFormula {
            trail_gain: 2.0,
            ..tyre
        },
        super::MagicFormula {
            twisting_gain: 2.0,
            ..tyre
        },
        super::MagicFormula {
            overturning_gain: 2.0,
            ..tyre
        },
    ];
    let plain = slopes(tyre);
    for (i, tyre) in scaled.into_iter().enumerate() {
        for (j, (found, plain)) in slopes(tyre).into_iter().zip(plain).enumerate() {
            let expected = if i == j { 2.0 * plain } else { plain };
            near(&format!("gain {i}, slope {j}"), found, expected, 1e-9);
        }
    }
}

/// Side by side with the 1989 formula evaluated by an independent Python program from its
/// published text: pressure in kPa, load in N, slip angle and camber in degrees (source's signs),
/// offsets kept, Fy in N, Mz in Nm.
#[test]
#[rustfmt::skip]
fn values_of_the_1989_formula() {
    let rows = [
        (300, 400.0, 1.0, 0.0, true, 92.72025020057416, -1.4786651512223674),
        (300, 400.0, -3.0, 5.0, true, -240.3963429783537, 3.3978804974711894),
        (300, 550.0, 2.0, -10.0, true, 138.29891470106622, -4.966742262867405),
        (300, 400.0, 0.0, 0.0, true, -8.012957730388631, 0.2368210121933939),
        (300, 400.0, 1.5, 4.0, false, 169.28045574372558, -2.057260500414003),
        (300, 700.0, -8.0, 20.0, false, -359.71149867423856, 8.514036062991323),
        (400, 400.0, 1.0, 0.0, true, 93.47421253449, -1.3305536517837813),
        (400, 400.0, -3.0, 5.0, true, -236.83157379744645, 2.9454891425544547),
        (400, 550.0, 2.0, -10.0, true, 159.57686200079462, -4.342495949210953),
        (400, 400.0, 0.0, 0.0, true, -6.065273046154784, 0.19790695212948461),
        (400, 400.0, 1.5, 4.0, false, 165.86147743425497, -1.6695396749863098),
        (400, 700.0, -8.0, 20.0, false, -382.43333635700054, 7.401097529208138),
        (500, 400.0, 1.0, 0.0, true, 100.13739303600605, -1.3926042812229484),
        (500, 400.0, -3.0, 5.0, true, -214.542446460116, 2.7696095919176003),
        (500, 550.0, 2.0, -10.0, true, 160.1932155660349, -4.000557039728754),
        (500, 400.0, 0.0, 0.0, true, 8.054100376407645, -0.04793349183533745),
        (500, 400.0, 1.5, 4.0, false, 156.6681164924155, -1.4387212234304103),
        (500, 700.0, -8.0, 20.0, false, -423.8926411244836, 11.283802158892314),
    ];
    for (pressure, load_n, slip, camber, offsets, fy, mz) in rows {
        let Tyre::MagicFormula1989(mut tyre) =
            set(&format!("schwalbe_t03_{pressure}kpa")).unwrap().tyre else { panic!() };
        tyre.remove_offsets = !offsets;
        let input = TyreInput {
            slip_angle_rad: -f64::to_radians(slip),
            camber_rad: f64::to_radians(camber),
            ..at(load_n)
        };
        let out = tyre.output(&input);
        let what = format!("{pressure} kPa, {load_n} N, {slip}, {camber}");
        near(&format!("Fy {what}"), out.lateral_n, fy, 1e-9);
        near(&format!("Mz {what}"), out.aligning_nm, mz, 1e-9);
    }
}
