use super::*;

/// Response of Σ r_j / (s - p_j) to a pulse of `pulse_s`, exactly, in closed form; `terms` holds
/// poles with their (complex) residues, of pairs the upper one.
fn response(terms: &[(Complex<f64>, Complex<f64>)], pulse_s: f64, t: f64) -> f64 {
    // Integral of exp(p (t - s)) over the pulse so far.
    let part = |p: Complex<f64>| {
        let exp = |x: f64| Complex::new(0.0, p.im * x).exp() * libm::exp(p.re * x);
        (exp(t) - exp(t - t.min(pulse_s))) / p
    };
    terms
        .iter()
        .map(|(p, r)| {
            if p.im == 0.0 {
                (r * part(*p)).re
            } else {
                2.0 * (r * part(*p)).re
            }
        })
        .sum()
}

const STEP_S: f64 = 0.01;
const PULSE_S: f64 = 0.1;

fn record(outputs: &[&[(Complex<f64>, Complex<f64>)]], seconds: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = (seconds / STEP_S) as usize;
    let input = (0..n).map(|k| {
        if (k as f64 + 0.5) * STEP_S < PULSE_S {
            0.1
        } else {
            0.0
        }
    });
    let ys = outputs.iter().map(|terms| {
        (0..n)
            .map(|k| 0.1 * response(terms, PULSE_S, k as f64 * STEP_S))
            .collect()
    });
    (input.collect(), ys.collect())
}

fn fit(outputs: &[&[(Complex<f64>, Complex<f64>)]], seconds: f64) -> FourPoles {
    let (input, ys) = record(outputs, seconds);
    let ys: Vec<&[f64]> = ys.iter().map(Vec::as_slice).collect();
    FourPoles::fit(&Response {
        step_s: STEP_S,
        input: &input,
        outputs: &ys,
    })
    .unwrap()
}

fn c(re: f64, im: f64) -> Complex<f64> {
    Complex::new(re, im)
}

#[test]
fn poles_of_known_systems_come_back() {
    let cases = [
        [c(-0.1, 5.0), c(-0.5, 0.0), c(-12.0, 0.0)],
        [c(0.9, 3.0), c(-0.2, 0.0), c(-9.0, 0.0)],
        [c(-2.0, 6.0), c(0.05, 0.0), c(-20.0, 0.0)],
    ];
    for [weave, capsize, caster] in cases {
        let roll = [
            (weave, c(0.3, -0.4)),
            (capsize, c(0.5, 0.0)),
            (caster, c(-1.1, 0.0)),
        ];
        let steer = [
            (weave, c(-0.6, 0.2)),
            (capsize, c(0.1, 0.0)),
            (caster, c(1.1, 0.0)),
        ];
        let found = fit(&[&roll, &steer], 8.0);
        let near = |wanted: Complex<f64>| {
            let error = |p: &Complex<f64>| libm::hypot(p.re - wanted.re, p.im - wanted.im);
            found.poles.iter().map(error).fold(f64::INFINITY, f64::min)
        };
        for pole in [weave, weave.conj(), capsize, caster] {
            assert!(near(pole) < 1.0e-7, "{pole}: {:?}", found.poles);
        }
        assert_eq!(found.weave(15.0).map(|w| w.re > 0.0), Some(weave.re > 0.0));
        assert!((found.slowest_real().unwrap() - capsize.re).abs() < 1.0e-7);
        assert!(found.relative_error < 1.0e-9, "{}", found.relative_error);
    }
}

#[test]
fn four_real_poles_come_back() {
    let reals = [0.4, -1.5, -4.0, -15.0];
    let outputs = [[1.0, -2.0, 0.5, 0.5], [0.2, 1.0, -1.0, -0.2]]
        .map(|r| core::array::from_fn::<_, 4, _>(|k| (c(reals[k], 0.0), c(r[k], 0.0))));
    let found = fit(&[&outputs[0], &outputs[1]], 6.0);
    for (pole, wanted) in found.poles.iter().zip([-15.0, -4.0, -1.5, 0.4]) {
        assert!(
            (pole.re - wanted).abs() < 1.0e-6 && pole.im == 0.0,
            "{:?}",
            found.poles
        );
    }
    assert_eq!(found.weave(15.0), None);
}

#[test]
fn modes_that_die_out_hardly_move_the_one_that_stays() {
    let weave = c(-0.05, 4.5);
    let others = |a: f64, b: f64, d: f64| {
        [
            (weave, c(a, 0.3)),
            (c(-0.7, 0.0), c(b, 0.0)),
            (c(-14.0, 0.0), c(d, 0.0)),
            (c(-2.5, 8.0), c(0.05 * d, 0.02)),
            (c(-40.0, 0.0), c(0.3, 0.0)),
            (c(-60.0, 20.0), c(0.1, 0.1)),
        ]
    };
    let found = fit(&[&others(0.4, -0.5, 0.2), &others(-0.7, 0.2, 0.8)], 12.0);
    let w = found.weave(15.0).unwrap();
    assert!(
        (w.re - weave.re).abs() < 2.0e-3 && (w.im - weave.im).abs() < 5.0e-3,
        "{w}"
    );
}

#[test]
fn records_that_say_nothing_are_refused() {
    let zeros = [0.0; 100];
    let mut pulse = zeros;
    pulse[0] = 1.0;
    let fit = |input: &[f64], y: &[f64]| {
        FourPoles::fit(&Response {
            step_s: STEP_S,
            input,
            outputs: &[y],
        })
        .unwrap_err()
    };
    assert!(matches!(fit(&zeros, &pulse), FourPoleError::Empty { .. }));
    assert!(matches!(fit(&pulse, &zeros), FourPoleError::Empty { .. }));
    assert!(matches!(
        fit(&pulse, &[f64::NAN; 100]),
        FourPoleError::Empty { .. }
    ));
    assert!(matches!(
        fit(&pulse[..20], &pulse[..20]),
        FourPoleError::Samples { .. }
    ));
    assert!(matches!(
        fit(&pulse, &pulse[..50]),
        FourPoleError::Samples { .. }
    ));
    let one_pole: Vec<f64> = (0..100).map(|k| libm::exp(-0.1 * f64::from(k))).collect();
    assert_eq!(fit(&pulse, &one_pole), FourPoleError::Order { found: 1 });
}
