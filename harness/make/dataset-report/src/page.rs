//! The page of a dataset.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use vb_dataset::{Dataset, Episode, EpisodeInfo, Header};
use vb_page::{Page, SORTED_TABLES, TABLE_STYLE, escape, grouped, number};
use vb_score::Cause;
use vb_world::{TerrainClass, World};

use crate::chart;
use crate::figures::{Counts, Figures, QUANTITIES};

const STYLE: &str = include_str!("page.css");

/// What fills a section of the page.
type Fill<'a> = fn(&Overview<'a>, &mut String);

/// Episodes that show what there is: of each outcome and cause in turn the next one, up to so many.
#[must_use]
pub fn examples(dataset: &Dataset, wanted: usize) -> BTreeSet<usize> {
    let mut kinds: Vec<((&str, &str), Vec<usize>)> = Vec::new();
    for (index, (info, frames)) in dataset.infos().enumerate() {
        if frames == 0 {
            continue;
        }
        let kind = (info.outcome.name(), info.cause.map_or("", Cause::name));
        match kinds.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, own)) => own.push(index),
            None => kinds.push((kind, vec![index])),
        }
    }
    kinds.sort();
    let longest = kinds.iter().map(|(_, own)| own.len()).max().unwrap_or(0);
    let in_turn = (0..longest).flat_map(|turn| kinds.iter().filter_map(move |(_, own)| own.get(turn)));
    in_turn.take(wanted).copied().collect()
}

/// An episode as the page shows it.
#[derive(Clone, Debug)]
pub struct Clip {
    index: usize,
    info: EpisodeInfo,
    picture: String,
    replay: Option<String>,
}

impl Clip {
    /// An episode in its world at the dataset's scale, with the address of its replay as seen from the page, if there is
    /// one.
    #[must_use]
    pub fn new(
        dataset: &Dataset,
        index: usize,
        episode: &Episode,
        world: &World,
        replay: Option<String>,
    ) -> Self {
        let view = episode.view(dataset.features());
        let way: Vec<[f64; 2]> = (0..episode.frames).map(|k| view.state(k)).map(|s| [s[0], s[1]]).collect();
        let mut picture = String::new();
        chart::way(&mut picture, world, &way);
        Self { index, info: episode.info.clone(), picture, replay }
    }
}

/// All that the page of a dataset shows.
pub struct Overview<'a> {
    pub header: &'a Header,
    pub hash: &'a str,
    pub figures: &'a Figures,
    pub clips: &'a [Clip],
}

impl<'a> Overview<'a> {
    /// The page: one file that needs nothing else.
    #[must_use]
    pub fn html(&self) -> String {
        let sections: [(&str, &str, Fill<'a>); 5] = [
            ("outcomes", "Outcomes", Self::outcomes),
            ("distributions", "Distributions", Self::distributions),
            ("episodes", "Episodes", Self::episodes),
            ("worlds", "Worlds", Self::worlds),
            ("about", "About", Self::about),
        ];
        let mut body = self.head(&sections.map(|(id, name, _)| (id, name)));
        body.push_str("<main>");
        for (id, name, fill) in sections {
            let _ = write!(body, "<section id=\"{id}\"><h2>{name}</h2>");
            fill(self, &mut body);
            body.push_str("</section>");
        }
        body.push_str("</main>");
        let styles = [TABLE_STYLE, STYLE];
        Page {
            title: &self.header.name,
            styles: &styles,
            body: &body,
            script: SORTED_TABLES,
            ..Page::default()
        }
        .html()
    }

    fn head(&self, sections: &[(&str, &str)]) -> String {
        let (f, h) = (self.figures, self.header);
        let mut s = format!(
            "<header><h1>{} <small>{} with the {}</small></h1><p class=\"meta\">hash <code title=\"{hash}\">{}</code>; Verti-Bench in \
             Rust {}; {}</p><nav>",
            escape(&h.name),
            h.kind.name(),
            escape(&h.vehicle.name),
            escape(self.hash.get(..12).unwrap_or(self.hash)),
            escape(&h.harness_version),
            escape(&h.licence),
            hash = escape(self.hash),
        );
        for (id, name) in sections {
            let _ = write!(s, "<a href=\"#{id}\">{name}</a>");
        }
        let hours = f.frames as f64 / f64::from(h.hz) / 3600.0;
        let facts = [
            ("episodes", grouped(f.episodes)),
            ("hours", number(hours, 2)),
            ("frames", grouped(f.frames)),
            ("km", number(f.distance_m / 1000.0, 1)),
            ("worlds", grouped(f.worlds.len() as u64)),
            ("frames per second", h.hz.to_string()),
        ];
        s.push_str("</nav><dl>");
        for (name, value) in facts {
            let _ = write!(s, "<div><dt>{name}</dt><dd>{value}</dd></div>");
        }
        s.push_str("</dl></header>");
        s
    }

    fn outcomes(&self, s: &mut String) {
        let f = self.figures;
        table(s, "terrain class at the end", &f.by_ground);
        table(s, "elevation level of the world", &f.by_elevation);
        table(s, "driver", &f.by_driver);
        if !f.by_cause.is_empty() {
            s.push_str("<h3>Causes of failures by terrain class</h3>");
            table(s, "cause", &f.by_cause);
        }
    }

    fn distributions(&self, s: &mut String) {
        s.push_str("<div class=\"plots\">");
        for (k, quantity) in QUANTITIES.iter().enumerate() {
            let groups: Vec<_> =
                self.figures.histograms.iter().map(|(name, all)| (name.as_str(), &all[k])).collect();
            chart::distribution(s, quantity, &groups);
        }
        s.push_str(
            "</div><p class=\"about\">One curve per terrain level of the worlds. The outermost 0.05 % of the frames at either \
             end are omitted.</p>",
        );
    }

    fn episodes(&self, s: &mut String) {
        s.push_str("<div class=\"clips\">");
        for clip in self.clips {
            let (index, info) = (clip.index, &clip.info);
            let name = match &clip.replay {
                Some(to) => format!("<a href=\"{}\">Episode {index}</a>", escape(to)),
                None => format!("Episode {index}"),
            };
            // The names of some causes begin with the outcome.
            let outcome = info.outcome.name();
            let end = match info.cause.map(Cause::name) {
                None => plain(outcome),
                Some(cause) if cause.starts_with(outcome) => plain(cause),
                Some(cause) => format!("{}: {}", plain(outcome), plain(cause)),
            };
            let _ = write!(
                s,
                "<figure><figcaption>{name}: {end}</figcaption>{}<p>{}, {} elevation, {} terrain; {:.1} s, {:.1} m; ends on {}</p></figure>",
                clip.picture,
                escape(&info.world),
                info.elevation.name(),
                info.terrain.name(),
                info.time_s,
                info.distance_m,
                info.ground.map_or("", TerrainClass::name),
            );
        }
        s.push_str(
            "</div><p class=\"about\">Examples of each outcome. Trajectories start at the green and end at the red point; north is up.</p>",
        );
    }

    fn worlds(&self, s: &mut String) {
        let h = self.header;
        let names: Vec<String> = self.figures.worlds.iter().map(|w| escape(w)).collect();
        let _ = write!(
            s,
            "<p>{} of the worlds of {} are used (folder <code>suite</code>, hash <code>{}</code>): {}.</p>",
            names.len(),
            escape(&h.worlds.name),
            escape(h.worlds.hash.get(..12).unwrap_or(&h.worlds.hash)),
            names.join(", ")
        );
        if h.of_a_suite {
            s.push_str("<p>Planners are evaluated on these worlds: do not train on this dataset.</p>");
        }
    }

    fn about(&self, s: &mut String) {
        let h = self.header;
        let rows = [
            ("vehicle", &h.vehicle),
            ("soils", &h.soils),
            ("rules", &h.rules),
            ("perception", &h.perception),
        ];
        s.push_str("<div class=\"scroll\"><table><tbody>");
        for (name, data) in rows {
            let hash = data.hash.get(..12).unwrap_or(&data.hash);
            let _ = write!(
                s,
                "<tr><th scope=\"row\">{name}</th><td>{}</td><td><code>{}</code></td></tr>",
                escape(&data.name),
                escape(hash)
            );
        }
        let _ = write!(
            s,
            "<tr><th scope=\"row\">scale</th><td>{}</td><td></td></tr><tr><th scope=\"row\">seed</th><td>{}</td><td></td></tr>\
             </tbody></table></div>",
            h.scale, h.seed
        );
        let _ = write!(
            s,
            "<p class=\"about\">Created with <code class=\"command\">vb-harness {}</code> at commit <code>{}</code>. README.md in the \
             dataset documents the columns.</p>",
            escape(&h.command.join(" ")),
            escape(&h.harness_commit),
        );
    }
}

/// The name of an outcome or a cause in words.
fn plain(name: &str) -> String {
    escape(&name.replace('_', " "))
}

/// Counts with a column for each name, and their sum.
fn table(s: &mut String, head: &str, counts: &Counts) {
    let columns: BTreeSet<&String> = counts.values().flat_map(|row| row.keys()).collect();
    let _ = write!(s, "<div class=\"scroll\"><table class=\"sortable\"><thead><tr><th>{}</th>", escape(head));
    for column in &columns {
        let _ = write!(s, "<th class=\"n\">{}</th>", plain(column));
    }
    s.push_str("<th class=\"n\">all</th></tr></thead><tbody>");
    for (name, row) in counts {
        let _ = write!(s, "<tr><th scope=\"row\">{}</th>", plain(name));
        let numbers = columns.iter().map(|c| row.get(*c).copied().unwrap_or(0));
        for n in numbers.chain([row.values().sum()]) {
            let _ = write!(s, "<td class=\"n\" data-v=\"{n}\">{}</td>", grouped(n));
        }
        s.push_str("</tr>");
    }
    s.push_str("</tbody></table></div>");
}
