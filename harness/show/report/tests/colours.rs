//! Whether the marks of the figures for papers have the colours of their runs in the pictures, not only in the style sheet: one rule
//! for a class that another drawing uses too would take them away.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

#[allow(dead_code, reason = "other tests use the rest of it")]
mod common;

use std::collections::BTreeSet;

use common::{header, record, write};
use vb_report::{Paper, Report, Runs};

/// The colours of the first three series on paper (`--c0` to `--c2` in `harness/show/page/src/tables.css`).
const SERIES: [[u8; 3]; 3] = [[0x00, 0x68, 0xd6], [0xb7, 0x84, 0x35], [0x2f, 0x88, 0x65]];
const WHITE: [u8; 3] = [255; 3];
const DPI: f64 = 300.0;

/// A colour of this opacity over white.
fn over_white(colour: [u8; 3], opacity: f64) -> [u8; 3] {
    colour.map(|c| (opacity * f64::from(c) + (1.0 - opacity) * 255.0).round() as u8)
}

struct Picture {
    width: usize,
    dots: Vec<[u8; 3]>,
    /// Pixels of a unit of the drawing.
    scale: f64,
}

impl Picture {
    fn of(figure: &vb_figure::Figure) -> Self {
        let file = figure.png(DPI).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let dots = bytes.chunks_exact(3).map(|d| [d[0], d[1], d[2]]).collect();
        let width = info.width as usize;
        Self { width, dots, scale: width as f64 / figure.units[0] }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [u8; 3] {
        self.dots[(y * self.scale) as usize * self.width + (x * self.scale) as usize]
    }

    /// How many dots have a colour, as nearly as rounding leaves it.
    fn count(&self, colour: [u8; 3]) -> usize {
        self.dots.iter().filter(|d| near(**d, colour)).count()
    }
}

fn near(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 3)
}

fn attribute(element: &str, name: &str) -> Option<f64> {
    element.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0.parse().ok()
}

/// The elements of a drawing that have this class among theirs, with all of their classes.
fn of_class<'a>(svg: &'a str, class: &'a str) -> impl Iterator<Item = (&'a str, Vec<&'a str>)> {
    svg.split('<').filter_map(move |element| {
        let element = element.split_once('>')?.0;
        let classes: Vec<&str> =
            element.split_once("class=\"")?.1.split_once('"')?.0.split_whitespace().collect();
        classes.contains(&class).then_some((element, classes))
    })
}

/// The series of which an element has the filling.
fn series(classes: &[&str]) -> usize {
    classes.iter().find_map(|c| c.strip_prefix('f')?.parse().ok()).unwrap()
}

/// Three runs over nine worlds: the first succeeds in no task with high relief, and all fail in some.
fn report(dir: &std::path::Path) -> Report {
    let run = |k: usize| {
        let name = format!("planner-{k}");
        let tasks = (0..9).flat_map(|w| (0..4).map(move |t| (w, t)));
        let success = |w: usize, t: usize| !((k == 0 && w % 3 == 2) || (w + t).is_multiple_of(k + 2));
        write(&dir.join(&name), &header(&name, 36), tasks.map(|(w, t)| record(w, t, success(w, t))))
    };
    Report::new(Runs::read(&[run(0), run(1), run(2)]).unwrap())
}

#[test]
fn bars_are_filled_with_the_colours_of_their_runs() {
    let dir = tempfile::tempdir().unwrap();
    let all = report(dir.path()).paper_figures(&Paper::new([3.5, 7.16], 8.0).unwrap());
    let results = all.iter().find(|f| f.name == "results").unwrap();
    let picture = Picture::of(&results.figure);
    let mut sampled = [0; 3];
    for (bar, classes) in of_class(&results.figure.body, "bar") {
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| attribute(bar, name).unwrap());
        if height < 8.0 {
            continue;
        }
        // Beside the whisker, which is in the middle.
        let found = picture.at([x + 0.2 * width, y + height - 3.0]);
        let run = series(&classes);
        assert!(near(found, over_white(SERIES[run], 0.85)), "{bar}: {found:?}");
        sampled[run] += 1;
    }
    assert!(sampled.iter().all(|n| *n > 12), "{sampled:?}");
}

#[test]
fn a_value_of_zero_has_no_bar_and_markers_are_beside_bars_and_whiskers() {
    let dir = tempfile::tempdir().unwrap();
    let all = report(dir.path()).paper_figures(&Paper::new([3.5, 7.16], 8.0).unwrap());
    let body = &all.iter().find(|f| f.name == "results").unwrap().figure.body;
    let zero = body.split("<g>").find(|g| g.contains("planner-0, high: 0.0 %")).unwrap();
    let zero = zero.split_once("</g>").unwrap().0;
    assert!(!zero.contains("<rect") && zero.contains("class=\"mark f0\""), "{zero}");
    let some = body.split("<g>").find(|g| g.contains("planner-1, high: ")).unwrap();
    assert!(some.split_once("</g>").unwrap().0.contains("<rect"), "{some}");
    // Each marker of a panel is below the lower end of its bar.
    let mut checked = 0;
    for group in body.split("<g>").filter(|g| g.contains("<rect class=\"f")) {
        let group = group.split_once("</g>").unwrap().0;
        let (bar, _) = of_class(group, "bar").next().unwrap();
        let base = attribute(bar, "y").unwrap() + attribute(bar, "height").unwrap();
        let d = of_class(group, "mark").next().unwrap().0.split_once(" d=\"M").unwrap().1;
        let numbers: Vec<f64> =
            d.split([' ', 'v', 'h', 'a', 'l', '"']).filter_map(|n| n.parse().ok()).collect();
        // All shapes begin within 1.3 radii of 4.2 units of their middle.
        assert!(numbers[1] > base + 0.5, "{numbers:?} at {base}");
        checked += 1;
    }
    assert!(checked > 36, "{checked}");
}

#[test]
fn each_figure_shows_each_run_in_its_colour() {
    let dir = tempfile::tempdir().unwrap();
    // What belongs to a run, and how much of its colour is left over white.
    let opacity = |name: &str| match name {
        "results" => 0.85,
        "distributions" => 0.28,
        _ => 1.0,
    };
    let mut seen = BTreeSet::new();
    for found in report(dir.path()).paper_figures(&Paper::new([3.5, 7.16], 8.0).unwrap()) {
        let picture = Picture::of(&found.figure);
        let shown = match found.name {
            // Two parts.
            "causes" => 0..2,
            // Each line is that of the later run of its pair, so the first has none.
            "comparison" => 1..3,
            _ => 0..3,
        };
        for colour in &SERIES[shown] {
            let count = picture.count(over_white(*colour, opacity(found.name)));
            assert!(count > 100, "{}: {count} dots of {colour:02x?}", found.name);
        }
        assert_eq!(picture.at([0.5, 0.5]), WHITE);
        seen.insert(found.name);
    }
    assert_eq!(seen.len(), 5, "{seen:?}");
}
