//! A world with the ways of all runs as a figure.

use std::fmt::Write as _;

use vb_figure::Figure;
use vb_page::escape;
use vb_score::Outcome;

use super::{Paper, Sheet};
use crate::WorldMap;
use crate::drawing::series;

/// Pixels along the longer side of the ground's picture: more than a column of 3.5 inches has dots at 300 an inch.
const GROUND: usize = 1080;
/// The radius of the ring where a way ended, in units of drawings.
const RING: f64 = 5.0;

impl WorldMap<'_> {
    /// The map as a figure in a column: the ground, obstacles, global paths, the ways of all runs in their colours, and a ring in the
    /// colour of the outcome where one ended without success, or at the goal if neither trace nor record says where.
    #[must_use]
    pub fn paper_figure(&self, paper: &Paper) -> Figure {
        let report = self.report;
        let mut sheet = report.sheet(paper, paper.column_in);
        if report.runs.runs.len() > 1 {
            sheet.legend(&report.paper_labels(), 2.0);
        }
        outcomes(self, &mut sheet);
        self.draw(&mut sheet);
        let world = self.world;
        sheet.finish(report.figure_title(&format!("Trajectories on {}", world.id)))
    }

    fn draw(&self, sheet: &mut Sheet) {
        let world = self.world;
        let half = [world.heightfield.half_x(), world.heightfield.half_y()];
        let scale = sheet.width / (2.0 * half[0]);
        let (width, height) = (sheet.width, 2.0 * half[1] * scale);
        let upper = sheet.y;
        let place = |p: [f64; 2]| [(p[0] + half[0]) * scale, upper + (half[1] - p[1]) * scale];
        let line = |points: &[[f64; 2]]| {
            let mut d = String::new();
            for (k, p) in points.iter().enumerate() {
                let [x, y] = place(*p);
                let _ = write!(d, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' });
            }
            d
        };
        let s = &mut sheet.body;
        let ground = vb_page::map::data_uri(&vb_page::map::ground(world, GROUND));
        let _ = write!(
            s,
            "<image x=\"0\" y=\"{upper:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" preserveAspectRatio=\"none\" \
             href=\"{ground}\"/>"
        );
        let outlines: String = world.obstacles.iter().map(|o| line(&o.footprint()) + "Z").collect();
        if !outlines.is_empty() {
            let _ = write!(s, "<path class=\"obstacle\" d=\"{outlines}\"/>");
        }
        for task in &world.tasks {
            let _ = write!(s, "<path class=\"plan\" d=\"{}\"/>", line(&task.path));
        }
        for way in self.ways.iter().filter(|w| w.points.len() > 1) {
            let d = line(&way.points);
            let _ = write!(
                s,
                "<path class=\"under\" d=\"{d}\"/><path class=\"{} way\" d=\"{d}\"/>",
                series::line(way.run)
            );
        }
        for task in &world.tasks {
            let ([x, y], [u, v]) = (place([task.start.x, task.start.y]), place(task.goal));
            let _ = write!(
                s,
                "<circle class=\"start\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"2.4\"/><circle class=\"goal\" cx=\"{u:.2}\" cy=\"{v:.2}\" r=\"3.4\"/>"
            );
        }
        // Failures over everything else: they are what one looks for.
        for way in self.ways.iter().filter(|w| !w.row.succeeded()) {
            let Some((end, _)) = way.end() else { continue };
            let at = place(end);
            ring(s, way.row.outcome, at);
            series::marker(s, way.run, at, 2.6, "");
        }
        // A bar of a round length in the lower left corner.
        let length = vb_page::map::bar_length(half[0]);
        let (x, y) = (8.0, upper + height - 8.0);
        let _ = write!(
            s,
            "<rect class=\"plate\" x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"20\"/><path class=\"scale\" d=\"M{x} {:.2}v4h{:.2}v-4\"/>\
             <text class=\"tick\" x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{} m</text>",
            x - 4.0,
            y - 16.0,
            length * scale + 8.0,
            y - 4.0,
            length * scale,
            x + 0.5 * length * scale,
            y - 5.0,
            escape(&((length * 1000.0).round() / 1000.0).to_string())
        );
        sheet.y += height;
    }
}

/// A ring in the colour of an outcome.
fn ring(s: &mut String, outcome: Outcome, [x, y]: [f64; 2]) {
    let _ =
        write!(s, "<circle class=\"ended e{}\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{RING}\"/>", outcome.index());
}

/// What the rings mean, of outcomes that are on the map.
fn outcomes(map: &WorldMap<'_>, sheet: &mut Sheet) {
    let there = |o: &Outcome| *o != Outcome::Success && map.ways.iter().any(|w| w.row.outcome == *o);
    let found: Vec<(Outcome, String)> =
        Outcome::ALL.into_iter().filter(there).map(|o| (o, o.name().replace('_', " "))).collect();
    let entries: Vec<series::Entry<'_>> =
        found.iter().map(|(_, name)| series::Entry { sign: 2.0 * RING + 2.0, name }).collect();
    let most = sheet.width - 4.0;
    let height = series::rows(&mut sheet.body, &entries, [2.0, sheet.y], most, |s, k, [x, y]| {
        ring(s, found[k].0, [x + RING + 1.0, y]);
    });
    sheet.y += height + if entries.is_empty() { 0.0 } else { 6.0 };
}
