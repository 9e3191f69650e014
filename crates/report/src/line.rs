//! A long series as a short line: lowest and highest value of each pixel column.
//!
//! Assumes and ignores: times rise. A sample whose time or value is not finite is a gap.

use std::fmt::Write as _;

use crate::axis::Axis;

/// Path data of `values` over `t`, about four numbers for each pixel column. Peaks survive: every
/// column keeps its first, lowest, highest and last sample.
pub fn path(t: &[f64], values: &[f64], x: &Axis, y: &Axis) -> String {
    let mut line = Line::default();
    let mut column: Option<Column> = None;
    for (&time, &value) in t.iter().zip(values) {
        if !(time.is_finite() && value.is_finite()) {
            if let Some(column) = column.take() {
                column.draw(&mut line);
            }
            line.lift();
            continue;
        }
        if time < x.low || time > x.high {
            continue;
        }
        let point = (x.at(time), y.at(value));
        match &mut column {
            Some(open) if open.number == point.0.floor() => open.add(point),
            open => {
                if let Some(done) = open.replace(Column::new(point)) {
                    done.draw(&mut line);
                }
            }
        }
    }
    if let Some(column) = column {
        column.draw(&mut line);
    }
    line.lift();
    line.d
}

type Point = (f64, f64);

/// The samples of one pixel column.
struct Column {
    number: f64,
    first: Point,
    top: Point,
    bottom: Point,
    last: Point,
}

impl Column {
    fn new(point: Point) -> Self {
        Self {
            number: point.0.floor(),
            first: point,
            top: point,
            bottom: point,
            last: point,
        }
    }

    fn add(&mut self, point: Point) {
        if point.1 < self.top.1 {
            self.top = point;
        }
        if point.1 > self.bottom.1 {
            self.bottom = point;
        }
        self.last = point;
    }

    fn draw(&self, line: &mut Line) {
        let (a, b) = if self.top.0 <= self.bottom.0 {
            (self.top, self.bottom)
        } else {
            (self.bottom, self.top)
        };
        for point in [self.first, a, b, self.last] {
            line.to(point);
        }
    }
}

/// Path data in tenths of a pixel, relative to the last point.
#[derive(Default)]
struct Line {
    d: String,
    /// Pen position in tenths, while it is down.
    pen: Option<(i64, i64)>,
    alone: bool,
}

impl Line {
    fn to(&mut self, (x, y): Point) {
        // Far outside the picture is far outside; it must not become a number of many digits.
        let tenths = |v: f64| (v * 10.0).round().clamp(-1e6, 1e6) as i64;
        let (x, y) = (tenths(x), tenths(y));
        match self.pen {
            None => {
                let _ = write!(self.d, "M{} {}", Tenths(x), Tenths(y));
                self.alone = true;
            }
            Some(at) if at == (x, y) => return,
            Some((px, py)) => {
                let _ = write!(self.d, "l{} {}", Tenths(x - px), Tenths(y - py));
                self.alone = false;
            }
        }
        self.pen = Some((x, y));
    }

    /// Ends the stroke; a point alone becomes a dot.
    fn lift(&mut self) {
        if self.pen.take().is_some() && self.alone {
            self.d.push_str("h0");
        }
        self.alone = false;
    }
}

/// A number of tenths, written short.
struct Tenths(i64);

impl std::fmt::Display for Tenths {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let (whole, part) = (self.0.unsigned_abs() / 10, self.0.unsigned_abs() % 10);
        match (whole, part) {
            (_, 0) => write!(f, "{sign}{whole}"),
            (0, _) => write!(f, "{sign}.{part}"),
            _ => write!(f, "{sign}{whole}.{part}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Axis = Axis {
        low: 0.0,
        high: 60.0,
        from_px: 0.0,
        to_px: 800.0,
    };
    const Y: Axis = Axis {
        low: -1.0,
        high: 1.0,
        from_px: 200.0,
        to_px: 0.0,
    };

    /// Absolute points of path data.
    fn points(d: &str) -> Vec<Vec<Point>> {
        let mut strokes: Vec<Vec<Point>> = Vec::new();
        let mut pen = (0.0, 0.0);
        for part in d
            .replace('M', "|M")
            .replace('l', "|l")
            .replace('h', "|h")
            .split('|')
            .skip(1)
        {
            let numbers: Vec<f64> = part[1..]
                .split(' ')
                .map(|n| n.parse().unwrap_or_else(|_| panic!("{part}")))
                .collect();
            match &part[..1] {
                "M" => {
                    pen = (numbers[0], numbers[1]);
                    strokes.push(vec![pen]);
                }
                "l" => {
                    pen = (pen.0 + numbers[0], pen.1 + numbers[1]);
                    strokes.last_mut().expect("stroke").push(pen);
                }
                _ => assert_eq!(numbers, [0.0]),
            }
        }
        strokes
    }

    #[test]
    fn sixty_thousand_samples_stay_small_and_keep_their_peaks() {
        let t: Vec<f64> = (0..60_000).map(|k| f64::from(k) * 1e-3).collect();
        let mut values: Vec<f64> = t.iter().map(|t| 0.5 * (40.0 * t).sin()).collect();
        values[31_415] = 0.97;
        values[31_416] = -0.93;
        let d = path(&t, &values, &X, &Y);
        assert!(d.len() < 800 * 4 * 10, "{} bytes", d.len());
        let strokes = points(&d);
        assert_eq!(strokes.len(), 1);
        let (low, high) = strokes[0]
            .iter()
            .fold((f64::MAX, f64::MIN), |r, p| (r.0.min(p.1), r.1.max(p.1)));
        assert!(
            (low - Y.at(0.97)).abs() <= 0.1 && (high - Y.at(-0.93)).abs() <= 0.1,
            "{low} {high}"
        );
        let end = strokes[0].last().expect("points");
        assert!((end.0 - X.at(59.999)).abs() <= 0.1 && (end.1 - Y.at(values[59_999])).abs() <= 0.1);
    }

    #[test]
    fn gaps_stay_gaps() {
        let t = [0.0, 10.0, 20.0, 30.0, 40.0, f64::NAN, 50.0];
        let values = [0.0, 0.5, f64::NAN, 0.2, f64::INFINITY, 0.1, -0.5];
        let strokes = points(&path(&t, &values, &X, &Y));
        assert_eq!(strokes.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1, 1]);
        assert!(
            path(&t, &values, &X, &Y).ends_with("h0"),
            "a sample alone is a dot"
        );
        assert_eq!(path(&[], &[], &X, &Y), "");
    }
}
