//! Published matrices, eigenvalues and speeds.

use crate::built_in;
use twinhub_linear::{Bicycle, Canonical, ModeName, Modes, MotorPair, Parameters, Verdict};

fn table() -> toml::Table {
    include_str!("../../../../tests/data/meijaard2007_eigenvalues.toml")
        .parse()
        .unwrap()
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().unwrap()
}

struct Tolerance {
    relative: f64,
    absolute: f64,
}

impl Tolerance {
    fn check(&self, what: &str, got: f64, want: f64) {
        let limit = self.relative * want.abs() + self.absolute;
        assert!(
            (got - want).abs() <= limit,
            "{what}: {got:.17} against {want:.17}, off by {:.1e}",
            got - want
        );
    }
}

#[test]
fn table_2_of_meijaard_2007() {
    let table = table();
    let tolerance = Tolerance {
        relative: number(&table["tolerance_relative"]),
        absolute: number(&table["tolerance_absolute"]),
    };
    let (_, equations) = built_in("meijaard2007_benchmark");
    let rows = table["row"].as_array().unwrap();
    assert_eq!(rows.len(), 10);
    let speeds: Vec<f64> = rows.iter().map(|r| number(&r["speed_m_s"])).collect();
    let modes = Modes::over(&equations, MotorPair::OFF, &speeds);
    let mut worst: f64 = 0.0;
    for (row, point) in rows.iter().zip(&modes.points) {
        let v = point.speed_m_s;
        let find = |name, positive: bool| {
            let mut all = point
                .modes
                .iter()
                .filter(|m| m.name == name && (m.pair.value.im >= 0.0) == positive);
            let one = all
                .next()
                .unwrap_or_else(|| panic!("no {name} at {v}"))
                .pair
                .value;
            assert!(all.next().is_none());
            one
        };
        let weave = find(ModeName::Weave, true);
        let want = row["weave"].as_array().unwrap();
        for (what, got, want) in [
            ("weave, real", weave.re, number(&want[0])),
            ("weave, imaginary", weave.im, number(&want[1])),
            (
                "capsize",
                find(ModeName::Capsize, true).re,
                number(&row["capsize"]),
            ),
            (
                "caster",
                find(ModeName::Caster, true).re,
                number(&row["caster"]),
            ),
        ] {
            tolerance.check(&format!("{what} at {v} m/s"), got, want);
            worst = worst.max((got - want).abs() / want.abs());
        }
    }
    println!("table 2: largest relative difference {worst:.1e}");

    let special = &table["special"];
    let still = equations.eigenvalues(0.0, MotorPair::OFF);
    for (i, want) in special["still_1_s"].as_array().unwrap().iter().enumerate() {
        assert!(still.iter().all(|s| s.im == 0.0));
        tolerance.check("still, stable", still[1 - i].re, -number(want));
        tolerance.check("still, unstable", still[2 + i].re, number(want));
    }
    let range = Modes::over(&equations, MotorPair::OFF, &[0.0, 10.0]);
    let weave = range.weave_speed_m_s().unwrap();
    tolerance.check("weave speed", weave, number(&special["weave_speed_m_s"]));
    tolerance.check(
        "capsize speed",
        range.capsize_speed_m_s().unwrap(),
        number(&special["capsize_speed_m_s"]),
    );
    assert_eq!(
        (range.weave, range.capsize),
        (Verdict::Crosses, Verdict::Crosses)
    );
    assert_eq!(
        range.stable_ranges_m_s,
        [[weave, range.capsize_speed_m_s().unwrap()]]
    );
    let at = equations.eigenvalues(weave, MotorPair::OFF);
    tolerance.check(
        "weave frequency",
        at[3].im,
        number(&special["weave_frequency_rad_s"]),
    );
    // At a double root an error e of the coefficients moves the roots by its square root.
    let double = equations.eigenvalues(number(&special["double_root_speed_m_s"]), MotorPair::OFF);
    let want = number(&special["double_root_1_s"]);
    assert!(
        (double[2] - want).norm() < 1e-6 && (double[3] - want).norm() < 1e-6,
        "{double:?}"
    );
    tolerance.check(
        "mean of the double root",
        0.5 * (double[2].re + double[3].re),
        want,
    );
}

#[test]
fn matrices_of_meijaard_2007() {
    // Equations (5.3) of the paper, there to 14 decimals.
    let (_, e) = built_in("meijaard2007_benchmark");
    let tolerance = Tolerance {
        relative: 0.0,
        absolute: 1.2e-14,
    };
    for (name, got, want) in [
        (
            "M",
            e.mass(),
            [
                80.81722,
                2.319_413_322_087_09,
                2.319_413_322_087_09,
                0.297_841_881_996_86,
            ],
        ),
        (
            "K0",
            e.k0(),
            [
                -80.95,
                -2.599_516_852_498_72,
                -2.599_516_852_498_72,
                -0.803_294_884_586_18,
            ],
        ),
        (
            "K2",
            e.k2(),
            [0.0, 76.597_345_895_732_22, 0.0, 2.654_315_237_946_04],
        ),
        (
            "C1",
            e.c1(),
            [
                0.0,
                33.866_413_914_924_94,
                -0.850_356_414_569_78,
                1.685_403_973_975_60,
            ],
        ),
    ] {
        for (i, want) in want.into_iter().enumerate() {
            let got = got[(i / 2, i % 2)];
            // The larger entries carry one more digit than a double has at 14 decimals.
            let slack = Tolerance {
                relative: 4.0 * f64::EPSILON,
                ..tolerance
            };
            slack.check(&format!("{name}[{i}]"), got, want);
        }
    }
}

#[test]
fn two_mass_skate_of_kooijman_2011() {
    // Science 332, 339: point masses, no gyroscopic effect, no trail to speak of; stable above
    // 2.8 m/s.
    let p = Parameters {
        w: 1.0,
        c: 0.0,
        lam: 5.0_f64.to_radians(),
        g: 9.81,
        rR: 0.0,
        mR: 0.0,
        IRxx: 0.0,
        IRyy: 0.0,
        xB: 1.2,
        zB: -0.4,
        mB: 10.0,
        IBxx: 0.0,
        IByy: 0.0,
        IBzz: 0.0,
        IBxz: 0.0,
        xH: 1.02,
        zH: -0.2,
        mH: 1.0,
        IHxx: 0.0,
        IHyy: 0.0,
        IHzz: 0.0,
        IHxz: 0.0,
        rF: 0.0,
        mF: 0.0,
        IFxx: 0.0,
        IFyy: 0.0,
    };
    let skate = Bicycle::new("skate", "Kooijman et al. (2011)", p).unwrap();
    let equations = Canonical::new(&skate).unwrap();
    assert_eq!(MotorPair::balanced(40.0, &skate), MotorPair::OFF);
    let modes = Modes::over(&equations, MotorPair::OFF, &[0.5, 10.0]);
    println!("skate: {:?} {:?}", modes.criticals, modes.stable_ranges_m_s);
    assert_eq!(modes.stable_ranges_m_s.len(), 1);
    let [from, to] = modes.stable_ranges_m_s[0];
    assert!((from - 2.8).abs() < 0.05, "{from}");
    assert_eq!(to, 10.0);
    assert_eq!(modes.capsize, Verdict::AlwaysStable);
}

#[test]
fn case_1_of_bulsink_2017() {
    // Thesis, case 1 (no slip, rigid rider): weave 4.9, capsize 6.8 m/s, printed to two digits.
    // Its parameters leave two readings open; both are shown, the default must be the nearer one.
    let miss = |spec: &str| {
        let (_, e) = built_in(spec);
        let m = Modes::over(&e, MotorPair::OFF, &[0.0, 15.0]);
        let (weave, capsize) = (m.weave_speed_m_s().unwrap(), m.capsize_speed_m_s().unwrap());
        println!("{spec}: weave {weave:.4} m/s, capsize {capsize:.4} m/s");
        ((weave - 4.9) / 4.9)
            .abs()
            .max(((capsize - 6.8) / 6.8).abs())
    };
    let default = miss("bulsink2017_bicycle1");
    let adams = miss("bulsink2017_bicycle1:products=adams");
    let tensor = miss("bulsink2017_bicycle1:products=tensor");
    miss("bulsink2017_bicycle1:products=adams,wheel_k=0.47");
    miss("bulsink2017_bicycle1:products=tensor,wheel_k=0.47");
    assert_eq!(default, adams.min(tensor));
    assert!(default < 0.05, "{default}");
}
