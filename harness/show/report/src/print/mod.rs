//! Figures for a paper: drawings of the report, laid out in the width of a column or a page.

mod map;
mod sheet;

use vb_figure::Figure;
use vb_page::plot::Frame;
use vb_score::Extent;

use crate::Report;
use crate::drawing::{
    Beside, Drawing, NAMES, Quantity, Scale, TEXT, causes, distribution, forest, level_frame, panel, profile,
    robustness, top,
};
use crate::figures::{Measure, Split};
use sheet::Sheet;

/// Least width of one of two drawings beside each other, units.
const COLUMN: f64 = 225.0;

/// What a paper wants of its figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// Width of a figure in a column, inches.
    column_in: f64,
    /// Width of a figure across the page, inches.
    page_in: f64,
    /// Size of most texts, points.
    font_pt: f64,
}

/// The widths leave no room for the texts, or the texts are none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PaperError {
    #[error(
        "a figure {what} of {width} in is too narrow for texts of {font} pt: it needs {least:.2} in (choose a larger width, or a smaller font)"
    )]
    Narrow {
        /// Whether it is in a column or across the page.
        what: &'static str,
        /// Its width, inches.
        width: f64,
        /// The size of texts, points.
        font: f64,
        /// The least width for them, inches.
        least: f64,
    },
    #[error("a font size of {0} pt is not valid in a figure (choose from 4 to 24)")]
    Font(f64),
}

impl Paper {
    /// Least widths in a column and across the page, in units of drawings.
    const LEAST: [f64; 2] = [260.0, 480.0];

    /// What a paper wants whose figures have these widths in a column and across the page, inches, and texts of this size, points.
    ///
    /// # Errors
    /// If the texts are smaller than 4 or larger than 24 points, or have no room in these widths.
    pub fn new([column_in, page_in]: [f64; 2], font_pt: f64) -> Result<Self, PaperError> {
        if !(4.0..=24.0).contains(&font_pt) {
            return Err(PaperError::Font(font_pt));
        }
        let wanted = [("in a column", column_in), ("across the page", page_in)];
        for ((what, width), units) in wanted.into_iter().zip(Self::LEAST) {
            let least = units * font_pt / TEXT / 72.0;
            // Not less than what the message says, which is rounded.
            if width < (100.0 * least).ceil() / 100.0 {
                let least = (100.0 * least).ceil() / 100.0;
                return Err(PaperError::Narrow { what, width, font: font_pt, least });
            }
        }
        Ok(Self { column_in, page_in, font_pt })
    }
}

/// A figure with the name of its files.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// The name without its ending.
    pub name: &'static str,
    pub figure: Figure,
}

impl Report {
    /// The figures of these runs, those for which there is something to draw: `results` always, `comparison` and `profiles` of
    /// several runs, `robustness` of runs under several perception profiles, `distributions`, and `causes` if tasks failed. If
    /// the report has a title, they have it too.
    #[must_use]
    pub fn paper_figures(&self, paper: &Paper) -> Vec<PaperFigure> {
        let figures = [
            ("results", Some(self.paper_results(paper))),
            ("comparison", self.paper_comparison(paper)),
            ("profiles", self.paper_profiles(paper)),
            ("robustness", self.paper_robustness(paper)),
            ("distributions", self.paper_distributions(paper)),
            ("causes", self.paper_causes(paper)),
        ];
        let named = |(name, figure): (_, Option<Figure>)| Some(PaperFigure { name, figure: figure? });
        figures.into_iter().filter_map(named).collect()
    }

    fn sheet(&self, paper: &Paper, inches: f64) -> Sheet {
        Sheet::new(paper, inches, self.title.as_deref())
    }

    /// The name of a figure for its readers: what it shows, and of what.
    fn figure_title(&self, shows: &str) -> String {
        let of = self.title.clone().unwrap_or_else(|| {
            self.runs.runs.iter().map(|r| r.label.as_str()).collect::<Vec<_>>().join(", ")
        });
        format!("{shows}: {of}")
    }

    fn paper_labels(&self) -> Vec<&str> {
        self.runs.runs.iter().map(|run| run.label.as_str()).collect()
    }

    /// The paper's figure: the panels of a row share their axis, those of a column their levels.
    fn paper_results(&self, paper: &Paper) -> Figure {
        let mut sheet = self.sheet(paper, paper.page_in);
        let (left, gap, rows, between) = (54.0, 12.0, 94.0, 17.0);
        if self.runs.runs.len() > 1 {
            sheet.legend(&self.paper_labels(), left);
        }
        let columns = Split::ALL.len() as f64;
        let wide = (sheet.width - left - 4.0 - gap * (columns - 1.0)) / columns;
        for (k, split) in Split::ALL.into_iter().enumerate() {
            let middle = left + (wide + gap) * k as f64 + 0.5 * wide;
            let y = sheet.y + 12.0;
            sheet.text("heading", [middle, y], "middle", &format!("By {}", split.name()));
        }
        sheet.y += 20.0;
        let last = Measure::ALL.len() - 1;
        for (row, measure) in Measure::ALL.into_iter().enumerate() {
            let upper = sheet.y + (rows + between) * row as f64;
            let end = top(self, measure);
            sheet.upright(
                "axis",
                [13.0, upper + 0.5 * rows],
                &format!("{}, {}", measure.name(), measure.unit()),
            );
            for (column, split) in Split::ALL.into_iter().enumerate() {
                let x = left + (wide + gap) * column as f64;
                // A frame whose area lies there; margins are up to the edges of the sheet.
                let f = Frame {
                    width: sheet.width,
                    height: upper + rows,
                    left: x,
                    right: sheet.width - x - wide,
                    top: upper,
                    bottom: 0.0,
                    ..level_frame(split, end)
                };
                let beside = Beside { values: column == 0, levels: row == last };
                panel(&mut sheet.body, self, measure, split, &f, beside);
            }
        }
        sheet.y += (rows + between) * Measure::ALL.len() as f64 + NAMES - 9.0;
        sheet.finish(
            self.figure_title("Success, time, roll and pitch by elevation, terrain and obstacle density"),
        )
    }

    fn paper_comparison(&self, paper: &Paper) -> Option<Figure> {
        let (c, ranking) = self.comparison.as_ref().zip(self.order.as_ref())?;
        let mut sheet = self.sheet(paper, paper.page_in);
        let columns = sheet.columns(COLUMN, 2);
        let wide = sheet.share(columns);
        let of = |measure| forest(self, c, ranking, measure, wide);
        let drawings: Vec<Drawing> = Measure::ALL.into_iter().filter_map(of).collect();
        if drawings.is_empty() {
            return None;
        }
        sheet.drawings(&drawings, columns);
        Some(sheet.finish(self.figure_title("Differences with 95 % intervals")))
    }

    fn paper_profiles(&self, paper: &Paper) -> Option<Figure> {
        let mut sheet = self.sheet(paper, paper.column_in);
        let drawing = profile(self, self.comparison.as_ref()?, sheet.width)?;
        sheet.legend(&self.paper_labels(), 4.0);
        self.alone(&mut sheet, &drawing);
        Some(sheet.finish(self.figure_title(&drawing.title)))
    }

    fn paper_robustness(&self, paper: &Paper) -> Option<Figure> {
        let r = self.robustness.as_ref()?;
        let mut sheet = self.sheet(paper, paper.column_in);
        let drawing = robustness(self, r, sheet.width);
        sheet.legend(&r.lines.iter().map(|line| line.label.as_str()).collect::<Vec<_>>(), 4.0);
        self.alone(&mut sheet, &drawing);
        Some(sheet.finish(self.figure_title(&drawing.title)))
    }

    fn paper_distributions(&self, paper: &Paper) -> Option<Figure> {
        let mut sheet = self.sheet(paper, paper.page_in);
        if self.runs.runs.len() == 1 {
            // Rows have no names then.
            sheet.y += 2.0;
        }
        let columns = sheet.columns(COLUMN, 2);
        let wide = sheet.share(columns);
        let of = |of: &Quantity| distribution(self, of, Scale::Linear, wide);
        let drawings: Vec<Drawing> = Quantity::all(Extent::Papers).iter().filter_map(of).collect();
        if drawings.is_empty() {
            return None;
        }
        sheet.drawings(&drawings, columns);
        Some(sheet.finish(self.figure_title("Distributions over tasks")))
    }

    fn paper_causes(&self, paper: &Paper) -> Option<Figure> {
        let mut sheet = self.sheet(paper, paper.column_in);
        let drawing = causes(self, sheet.width)?;
        self.alone(&mut sheet, &drawing);
        Some(sheet.finish(self.figure_title(&drawing.title)))
    }

    /// A drawing that has its sheet for itself, and needs no name on it: the paper's caption says it.
    fn alone(&self, sheet: &mut Sheet, drawing: &Drawing) {
        let y = sheet.y;
        sheet.place(drawing, [0.0, y]);
        sheet.y += drawing.height;
    }
}
