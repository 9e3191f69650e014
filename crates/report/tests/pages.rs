//! Pages and charts as files: well-formed, self-contained, small, nothing outside the picture.

use twinhub_report::chart::{Band, Chart, Level, Panel, Series};
use twinhub_report::page::Tone;
use twinhub_report::ride::{Ride, RidePage, Signals, Stretch, ride_page, verdict};

fn times() -> Vec<f64> {
    (0..60_000).map(|k| f64::from(k) * 1e-3).collect()
}

fn ride(name: &str) -> Ride {
    let t_s = times();
    let wave = |size: f64, rate: f64| -> Vec<f64> {
        t_s.iter().map(|t| size * (rate * t).sin()).collect()
    };
    Ride {
        name: name.into(),
        roll_rms_rad: 0.02,
        steer_rms_rad: 0.03,
        rider_effort_rms_nm: 2.0,
        energy_j: 100.0,
        ticks: 60_000,
        digest: "00ff".into(),
        log: format!("{name}.mcap"),
        signals: Signals {
            roll_rad: wave(0.03, 5.0),
            steer_rad: wave(0.05, 900.0),
            rider_torque_nm: wave(3.0, 40.0),
            speed_m_s: wave(6.0, 0.01),
            front_brake_nm: wave(30.0, 1.0),
            rear_traction_nm: wave(30.0, 1.3),
            t_s,
        },
        ..Ride::default()
    }
}

fn page(rides: Vec<Ride>) -> RidePage {
    RidePage {
        title: "First <ride> & \"more\"".into(),
        lead: "]]> '<script>alert(1)</script>".into(),
        rides,
        stretches: vec![Stretch {
            from_s: 20.0,
            to_s: 21.0,
            name: "<push>".into(),
        }],
        no_slip: true,
        notes: vec!["<b>".into()],
        provenance: vec![("seed".into(), "<7>".into())],
        config_text: "a = \"<\u{1b}&\"\n".into(),
        commands: vec!["twinhub ride > x".into()],
    }
}

/// The page as XML: HTML without an opening line, void elements closed.
fn parse(html: &str) -> roxmltree::Document<'_> {
    let xml = html.strip_prefix("<!doctype html>\n").expect("doctype");
    roxmltree::Document::parse(xml).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_page_is_well_formed_whatever_the_texts_are() {
    let html = ride_page(&page(vec![ride("off <&>"), ride("on")]));
    let document = parse(&html);
    let heading = document
        .descendants()
        .find(|n| n.has_tag_name("h1"))
        .and_then(|n| n.text());
    assert_eq!(heading, Some("First <ride> & \"more\""));
    for element in ["script", "link", "img", "iframe", "b", "push"] {
        assert!(
            document
                .descendants()
                .all(|n| n.tag_name().name() != element),
            "{element}"
        );
    }
}

#[test]
fn a_page_fetches_nothing() {
    let html = ride_page(&page(vec![ride("off"), ride("on")]));
    let rest = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in [
        "http:",
        "https:",
        "url(",
        "@import",
        "src=",
        "href=",
        "javascript:",
    ] {
        assert!(!rest.contains(word), "{word}");
    }
}

#[test]
fn a_minute_at_a_thousand_hertz_stays_small() {
    let html = ride_page(&page(vec![ride("off"), ride("on")]));
    // Twelve lines of noise over 900 pixels, 2 to 4 points each.
    assert!(html.len() < 600_000, "{} bytes", html.len());
}

#[test]
fn gaps_and_nonsense_are_drawn_as_nothing() {
    let mut broken = ride("on");
    for signal in [&mut broken.signals.roll_rad, &mut broken.signals.speed_m_s] {
        signal[100..5_000].fill(f64::NAN);
        signal[7_000] = f64::INFINITY;
    }
    broken.signals.steer_rad.fill(f64::NAN);
    broken.signals.rider_torque_nm.truncate(10);
    broken.roll_rms_rad = f64::NAN;
    let html = ride_page(&page(vec![Ride::default(), broken.clone()]));
    parse(&html);
    assert!(
        !html.contains("NaN") && !html.contains("inf"),
        "numbers that are none"
    );
    parse(&ride_page(&page(vec![])));
    parse(&ride_page(&RidePage::default()));
    let empty = Chart {
        panels: vec![Panel {
            title: "Nothing",
            ..Panel::default()
        }],
        ..Chart::default()
    };
    assert!(empty.svg().contains("no data"));
}

/// Texts as boxes: x, y, width, height, by generous measure.
fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = roxmltree::Document::parse(svg).expect("well-formed");
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts
        .map(|n| {
            let number = |key: &str| {
                n.attribute(key)
                    .and_then(|v| v.parse::<f64>().ok())
                    .expect("number")
            };
            let text: String = n
                .descendants()
                .filter_map(|d| d.is_text().then(|| d.text()).flatten())
                .collect();
            let width = 6.6 * text.chars().count() as f64;
            let left = match n.attribute("text-anchor") {
                Some("middle") => number("x") - width / 2.0,
                Some("end") => number("x") - width,
                _ => number("x"),
            };
            (text, [left, number("y") - 10.0, width, 12.0])
        })
        .collect()
}

#[test]
fn no_text_runs_into_another_or_out_of_the_picture() {
    let t = times();
    let y: Vec<f64> = t.iter().map(|t| 1e-3 * t.sin()).collect();
    let names = [
        "a rather long name of a ride",
        "another long name of a ride",
        "a third one",
        "limit",
        "fifth of them all",
    ];
    let series = |n: usize| -> Vec<Series> {
        (0..n)
            .map(|style| Series {
                name: names[style],
                style,
                x: &t,
                y: &y,
            })
            .collect()
    };
    let chart = Chart {
        panels: vec![
            Panel {
                title: "Steer torque of the rider",
                unit: "Nm",
                series: series(5),
                levels: vec![Level {
                    value: 0.002,
                    name: "limit",
                }],
            },
            Panel {
                title: "Roll",
                unit: "°",
                series: series(2),
                levels: vec![],
            },
            Panel {
                title: "Empty",
                unit: "",
                series: vec![],
                levels: vec![],
            },
        ],
        bands: vec![
            Band {
                from: 0.0,
                to: 0.5,
                name: "a push at the start",
            },
            Band {
                from: 1.0,
                to: 1.5,
                name: "one right after it",
            },
            Band {
                from: 59.9,
                to: 90.0,
                name: "a push at the very end",
            },
            Band {
                from: 70.0,
                to: 80.0,
                name: "outside",
            },
        ],
        ..Chart::default()
    };
    let svg = chart.svg();
    let boxes = boxes(&svg);
    assert!(boxes.len() > 30);
    for (i, (a, [ax, ay, aw, ah])) in boxes.iter().enumerate() {
        assert!(*ax >= 0.0 && ax + aw <= 962.0, "`{a}` leaves the picture");
        for (b, [bx, by, bw, bh]) in &boxes[i + 1..] {
            let apart = ax + aw <= *bx || bx + bw <= *ax || ay + ah <= *by || by + bh <= *ay;
            assert!(apart, "`{a}` and `{b}` overlap");
        }
    }
    let seen: Vec<&str> = boxes.iter().map(|(text, _)| text.as_str()).collect();
    assert!(seen.contains(&"a push at the start") && seen.contains(&"a push at the very end"));
    assert!(!seen.contains(&"one right after it"), "no room for it");
    assert!(svg.contains("<title>one right after it</title>") && !svg.contains("outside"));
}

#[test]
fn the_verdict_says_what_happened() {
    let (off, mut on) = (ride("stabilizer off"), ride("stabilizer on"));
    let tell = |off: &Ride, on: &Ride| verdict(&[off.clone(), on.clone()]);
    assert_eq!(tell(&off, &on).0, Tone::Even);
    on.rider_effort_rms_nm = 1.5;
    let (tone, sentence) = tell(&off, &on);
    assert_eq!(tone, Tone::Good);
    assert!(
        sentence.contains("25 % smaller (1.50 against 2.00 Nm rms)"),
        "{sentence}"
    );
    assert!(
        sentence.contains("roll was about the same (1.15° against 1.15° rms)"),
        "{sentence}"
    );
    on.roll_rms_rad = 0.03;
    assert_eq!(tell(&off, &on).0, Tone::Even, "better and worse");
    on.rider_effort_rms_nm = 2.5;
    assert_eq!(tell(&off, &on).0, Tone::Bad);
    on.fell = true;
    let (tone, sentence) = tell(&off, &on);
    assert_eq!(
        (tone, sentence.as_str()),
        (
            Tone::Bad,
            "The bicycle rode all 60.0 s (stabilizer off) and fell after 60.0 s (stabilizer on)."
        )
    );
    assert_eq!(tell(&on, &off).0, Tone::Good);
    assert_eq!(verdict(&[on.clone()]).0, Tone::Bad);
    assert_eq!(tell(&on, &on).0, Tone::Bad);
    on.fell = false;
    on.rider_effort_rms_nm = f64::NAN;
    assert!(
        tell(&off, &on)
            .1
            .contains("effort was not comparable (n/a against")
    );
}
