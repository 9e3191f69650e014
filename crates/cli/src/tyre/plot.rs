//! The picture of `twinhub tyre --out`: forces and moment over the input that is swept.

use super::{COLUMNS, Point};
use anyhow::{Result, anyhow};
use std::fmt::Write as _;

const WIDTH: f64 = 720.0;
const PANEL: f64 = 240.0;
const LEFT: f64 = 80.0;
const RIGHT: f64 = 20.0;
const GAP: f64 = 50.0;
/// Inputs that can be swept, the one to draw over first: columns of [`Point::values`].
const SWEPT: [usize; 4] = [1, 3, 2, 0];
/// What is drawn: columns of [`Point::values`] and a colour.
const DRAWN: [(usize, &str); 3] = [(5, "#1f77b4"), (4, "#d62728"), (8, "#2ca02c")];

/// One panel for each of side force, longitudinal force and moment about z; one line for each
/// combination of the other inputs.
pub fn picture(name: &str, points: &[Point]) -> Result<String> {
    let rows: Vec<_> = points.iter().map(Point::values).collect();
    let over = SWEPT
        .into_iter()
        .find(|&i| rows.iter().any(|row| row[i] != rows[0][i]))
        .ok_or_else(|| anyhow!("--out needs a sweep, as --slip-angle-rad=-0.2:0.2:0.01"))?;
    let others: Vec<usize> = SWEPT.into_iter().filter(|&i| i != over).collect();
    let mut lines: Vec<Vec<[f64; 9]>> = Vec::new();
    let same = |a: &[f64; 9], b: &[f64; 9]| others.iter().all(|&i| a[i] == b[i]);
    for row in rows {
        match lines.iter_mut().find(|line| same(&line[0], &row)) {
            Some(line) => line.push(row),
            None => lines.push(vec![row]),
        }
    }

    let height = DRAWN.len() as f64 * (PANEL + GAP) + 40.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{LEFT}\" y=\"20\" font-size=\"14\">{name}</text>\n"
    );
    let bounds = |column: usize| {
        let all = lines.iter().flatten().map(|row| row[column]);
        let (low, high) = all.fold((f64::MAX, f64::MIN), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        if low < high {
            (low, high)
        } else {
            (low - 1.0, high + 1.0)
        }
    };
    let (x_low, x_high) = bounds(over);
    for (panel, (column, colour)) in DRAWN.into_iter().enumerate() {
        let top = 36.0 + panel as f64 * (PANEL + GAP);
        let (y_low, y_high) = bounds(column);
        let px = |x: f64| LEFT + (x - x_low) / (x_high - x_low) * (WIDTH - LEFT - RIGHT);
        let py = |y: f64| top + PANEL - (y - y_low) / (y_high - y_low) * PANEL;
        let _ = writeln!(
            svg,
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{}\" height=\"{PANEL}\" fill=\"none\" \
             stroke=\"#888\"/>",
            WIDTH - LEFT - RIGHT
        );
        for step in 0..=4 {
            let share = f64::from(step) / 4.0;
            let (x, y) = (
                x_low + share * (x_high - x_low),
                y_low + share * (y_high - y_low),
            );
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{x:.4}</text>\n\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{y:.2}</text>",
                px(x),
                top + PANEL + 15.0,
                LEFT - 6.0,
                py(y) + 4.0,
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{} over {}</text>",
            0.5 * (LEFT + WIDTH - RIGHT),
            top + PANEL + 31.0,
            COLUMNS[column],
            COLUMNS[over],
        );
        for line in &lines {
            let mut path = String::new();
            for row in line {
                let _ = write!(path, "{:.2},{:.2} ", px(row[over]), py(row[column]));
            }
            let _ = writeln!(
                svg,
                "<polyline fill=\"none\" stroke=\"{colour}\" points=\"{}\"/>",
                path.trim_end()
            );
        }
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(slip_angle_rad: f64, camber_rad: f64) -> Point {
        Point {
            load_n: 400.0,
            slip_angle_rad,
            camber_rad,
            slip_ratio: 0.0,
            longitudinal_n: 0.0,
            lateral_n: -slip_angle_rad,
            overturning_nm: 0.0,
            rolling_resistance_nm: 0.0,
            aligning_nm: 0.0,
        }
    }

    #[test]
    fn every_combination_of_the_other_inputs_is_a_line_in_every_panel() {
        let points: Vec<_> = [0.0, 0.1]
            .iter()
            .flat_map(|&g| [-0.1, 0.0, 0.1].map(|a| point(a, g)))
            .collect();
        let svg = picture("name", &points).unwrap();
        assert_eq!(svg.matches("<polyline").count(), 2 * DRAWN.len());
        assert!(svg.contains("lateral_n over slip_angle_rad") && !svg.contains("NaN"));
        assert!(
            picture("name", &points[..1]).is_err(),
            "one point is no curve"
        );
    }
}
