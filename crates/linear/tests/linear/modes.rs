//! Modes by brute force, and of other matrices.

use crate::built_in;
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use twinhub_linear::{
    Bicycle, Canonical, Layout, ModeName, Modes, MotorPair, eigenpairs, follow, name,
};

/// The benchmark with every parameter moved.
fn moved(factors: &[f64]) -> Option<Canonical> {
    let (mut b, _) = built_in("meijaard2007_benchmark");
    for (symbol, f) in [
        "w", "c", "lam", "xB", "zB", "mB", "xH", "zH", "mH", "IRyy", "IFyy", "rF",
    ]
    .iter()
    .zip(factors)
    {
        b.set(symbol, b.get(symbol).unwrap() * f).ok()?;
    }
    Canonical::new(&b).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn stable_ranges_are_those_of_the_eigenvalues(
        factors in proptest::collection::vec(0.8..1.2_f64, 12), torque in -40.0..80.0_f64, rear in -20.0..40.0_f64
    ) {
        let Some(e) = moved(&factors) else { return Ok(()) };
        let pair = MotorPair { front_brake_nm: torque, rear_traction_nm: rear };
        let modes = Modes::over(&e, pair, &[0.0, 12.0]);
        for k in 0..240 {
            let v = 0.025 + 0.05 * k as f64;
            let growth = e.eigenvalues(v, pair).iter().map(|s| s.re).fold(f64::MIN, f64::max);
            let inside = modes.stable_ranges_m_s.iter().any(|[a, b]| *a <= v && v <= *b);
            prop_assert!(growth.abs() < 1e-9 || inside == (growth < 0.0), "{v} m/s: {growth} {:?}", modes.stable_ranges_m_s);
        }
        for c in &modes.criticals {
            let nearest = e.eigenvalues(c.speed_m_s, pair).iter().map(|s| s.re.abs()).fold(f64::MAX, f64::min);
            prop_assert!(nearest < 1e-9, "{c:?} {nearest:e}");
        }
    }

    #[test]
    fn eigenvalues_annul_the_determinant(
        factors in proptest::collection::vec(0.8..1.2_f64, 12), v in -5.0..15.0_f64, torque in 0.0..80.0_f64
    ) {
        let Some(e) = moved(&factors) else { return Ok(()) };
        let pair = MotorPair { front_brake_nm: torque, rear_traction_nm: torque };
        let (m, c, k) = (e.mass(), e.damping(v), e.stiffness(v, pair));
        for mode in e.eigenpairs(v, pair) {
            let s = mode.value;
            let d = |i, j| s * s * m[(i, j)] + s * c[(i, j)] + Complex::new(k[(i, j)], 0.0);
            let (a, b) = (d(0, 0) * d(1, 1), d(0, 1) * d(1, 0));
            let size = |i: usize, j: usize| s.norm_sqr() * m[(i, j)].abs() + s.norm() * c[(i, j)].abs() + k[(i, j)].abs();
            let scale = size(0, 0) * size(1, 1) + size(0, 1) * size(1, 0);
            prop_assert!((a - b).norm() < 1e-13 * scale, "{s}: {:e} of {scale:e}", (a - b).norm());
            // And the shape is an eigenvector of the state matrix.
            let matrix = e.state_matrix(v, pair).map(|x| Complex::new(x, 0.0));
            let x = nalgebra::Vector4::from_iterator(mode.shape.iter().copied());
            let rest = (matrix * x - x * s).norm();
            prop_assert!(rest < 1e-9 * matrix.norm(), "{s}: {rest:e}");
        }
    }

    #[test]
    fn any_matrix_has_its_eigenpairs(entries in proptest::collection::vec(-5.0..5.0_f64, 64)) {
        let a = DMatrix::from_row_slice(8, 8, &entries);
        let pairs = eigenpairs(&a).unwrap();
        prop_assert_eq!(pairs.len(), 8);
        let complex = a.map(|x| Complex::new(x, 0.0));
        let sum: f64 = pairs.iter().map(|p| p.value.re).sum();
        prop_assert!((sum - a.trace()).abs() < 1e-9);
        for p in &pairs {
            let x = nalgebra::DVector::from_vec(p.shape.clone());
            let rest = (&complex * &x - &x * p.value).norm();
            prop_assert!(rest < 1e-7, "{} {rest:e}", p.value);
        }
    }
}

#[test]
fn general_route_gives_the_same_names_and_branches() {
    let (b, e) = built_in("bulsink2017_bicycle1");
    let pair = MotorPair::balanced(20.0, &b);
    let speeds: Vec<f64> = (50..=1000).map(|k| 0.01 * k as f64).collect();
    let modes = Modes::over(&e, pair, &speeds);
    let family: Vec<_> = speeds
        .iter()
        .map(|v| {
            let a = e.state_matrix(*v, pair);
            eigenpairs(&DMatrix::from_iterator(4, 4, a.iter().copied())).unwrap()
        })
        .collect();
    let last = family.len() - 1;
    let names = name(&family[last], &Layout::benchmark());
    for (k, branch) in follow(&family, last).into_iter().enumerate() {
        for (b, index) in branch.into_iter().enumerate() {
            let here = family[k][index].value;
            let same = modes.points[k].modes.iter().min_by(|x, y| {
                (x.pair.value - here)
                    .norm()
                    .total_cmp(&(y.pair.value - here).norm())
            });
            let same = same.unwrap();
            assert!(
                (same.pair.value - here).norm() < 1e-5,
                "{} {here}",
                same.pair.value
            );
            assert_eq!(same.name, names[b], "{} m/s {here}", speeds[k]);
        }
    }
}

#[test]
fn capsize_and_weave_speed_by_hand() {
    // det K = 0 is linear in v² here, and a Hopf point has s = i w with both parts of the
    // determinant zero.
    let (_, e) = built_in("bulsink2017_bicycle1");
    let modes = Modes::over(&e, MotorPair::OFF, &[0.0, 12.0]);
    let (k0, k2, g) = (e.k0(), e.k2(), 9.81);
    let still = k0[(0, 0)] * k0[(1, 1)] - k0[(0, 1)] * k0[(1, 0)];
    let moving = k0[(0, 0)] * k2[(1, 1)] - k0[(1, 0)] * k2[(0, 1)];
    let capsize = (-g * still / moving).sqrt();
    assert!((modes.capsize_speed_m_s().unwrap() / capsize - 1.0).abs() < 1e-12);
    let v = modes.weave_speed_m_s().unwrap();
    let weave = e
        .eigenvalues(v, MotorPair::OFF)
        .into_iter()
        .find(|s| s.im > 0.0)
        .unwrap();
    assert!(weave.re.abs() < 1e-12, "{weave}");
}

#[test]
fn names_hold_from_standstill_to_high_speed() {
    let (_, e) = built_in("meijaard2007_benchmark");
    let speeds: Vec<f64> = (0..=100).map(|k| 0.1 * k as f64).collect();
    for point in Modes::over(&e, MotorPair::OFF, &speeds).points {
        let of = |name| {
            point
                .modes
                .iter()
                .filter(move |m| m.name == name)
                .map(|m| m.pair.value)
                .collect::<Vec<_>>()
        };
        let (weave, capsize, caster) = (
            of(ModeName::Weave),
            of(ModeName::Capsize),
            of(ModeName::Caster),
        );
        assert_eq!(
            (weave.len(), capsize.len(), caster.len()),
            (2, 1, 1),
            "{point:?}"
        );
        assert!(caster[0].re < -5.5 && capsize[0].re > -3.2 && capsize[0].re < 0.2);
    }
}

#[test]
fn a_nan_in_a_matrix_is_an_error() {
    let mut a = DMatrix::<f64>::identity(3, 3);
    a[(2, 1)] = f64::NAN;
    assert!(
        eigenpairs(&a)
            .unwrap_err()
            .to_string()
            .contains("row 2, column 1")
    );
    assert!(Bicycle::load("").is_err());
}
