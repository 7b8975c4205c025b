//! OpenCRG files (.crg): courses as a curved regular grid of heights (ASAM OpenCRG 1.2, chapter 6).
//!
//! Options that say what lies beyond the borders and modifiers that move a course as a whole change nothing here: a world is made
//! about the course's middle, and its ground goes on as OpenCRG's default says. What would change heights or shape is either
//! applied or refused.

mod data;
mod header;

use std::path::Path;

use super::finish::{Found, Lay};
use super::{Flaw, ReadError};
use crate::ElevationImage;
use crate::course::{Course, Parts};
use crate::crs::Length;
use header::{Channel, Header, Value, Values, flaw};

/// The longest file, bytes.
const MOST_BYTES: u64 = 1 << 29;
/// The most samples of a raster that is made of a course.
const MOST_SAMPLES: f64 = (1 << 23) as f64;
/// The greatest coordinate, m, and the greatest slope.
const FARTHEST: f64 = 1e6;
const STEEPEST: f64 = 10.0;
/// Tolerance of lengths that must agree, as a fraction of the increment.
const AGREEMENT: f64 = 1e-3;

/// The name of the format.
pub(super) const FORMAT: &str = "OpenCRG";

/// Modifiers that move a course as a whole.
const MOVES: [&str; 15] = [
    "REFPOINT_U",
    "REFPOINT_V",
    "REFPOINT_U_FRACTION",
    "REFPOINT_U_OFFSET",
    "REFPOINT_V_FRACTION",
    "REFPOINT_V_OFFSET",
    "REFPOINT_X",
    "REFPOINT_Y",
    "REFPOINT_Z",
    "REFPOINT_PHI",
    "REFLINE_ROTCENTER_X",
    "REFLINE_ROTCENTER_Y",
    "REFLINE_OFFSET_X",
    "REFLINE_OFFSET_Y",
    "REFLINE_OFFSET_PHI",
];

/// A course of a file.
#[derive(Clone, Debug)]
pub struct CourseFile {
    pub course: Course,
    /// Notes for the user on assumptions and ignored parts of the file, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a course from an OpenCRG file.
///
/// # Errors
/// Returns an error with the line or field for a file that is damaged, too large or stored in a way that is not read.
pub fn course(path: &Path) -> Result<CourseFile, ReadError> {
    read(path).map_err(|flaw| ReadError { path: path.to_owned(), flaw })
}

pub(super) fn read(path: &Path) -> Result<CourseFile, Flaw> {
    let size = std::fs::metadata(path)?.len();
    if size > MOST_BYTES {
        return Err(Flaw::TooLarge { found: size, limit: MOST_BYTES, unit: "bytes" });
    }
    parse(&vb_files::read(path, MOST_BYTES)?)
}

/// A raster over the extents of a course, with holes beyond its borders.
pub(super) fn found(path: &Path) -> Result<Found, Flaw> {
    let CourseFile { course, mut notes } = read(path)?;
    let [low, high] = course.extents();
    let finest = course.increment().min(course.finest_section());
    let samples = |side: f64| [0, 1].map(|k| ((high[k] - low[k]) / side * (1.0 + 1e-12)).floor() + 1.0);
    let mut side = finest;
    while samples(side).iter().product::<f64>() > MOST_SAMPLES {
        side *= 2.0;
    }
    if side > finest {
        notes.push(format!(
            "the height spacing is {side} m instead of {finest} m in the file, because of the extents"
        ));
    }
    let [cols, rows] = samples(side).map(|n| n as usize);
    super::check_size(rows as u64, cols as u64)?;
    let ([from, to], [right, left]) = (course.span(), course.borders());
    let slack = 1e-6 * course.increment();
    let mut values = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        for col in 0..cols {
            let at = [low[0] + col as f64 * side, low[1] + (rows - 1 - row) as f64 * side];
            let [u, v] = course.coordinates(at);
            let within = u >= from - slack && u <= to + slack && v >= right - slack && v <= left + slack;
            values.push(if within { course.height(u, v) } else { f64::NAN });
        }
    }
    let raster = ElevationImage::new(rows, cols, values);
    let first = [low[0], low[1] + (rows - 1) as f64 * side];
    Ok(Found {
        lay: Some(Lay::north_up(Some(first), [side; 2])),
        unit: Some(Length::metre()),
        suspects: false,
        notes,
        ..Found::plain(FORMAT, raster)
    })
}

/// The course that the bytes of a file describe.
fn parse(bytes: &[u8]) -> Result<CourseFile, Flaw> {
    let header = Header::read(bytes)?;
    let mut notes = Vec::new();
    let road = &header.road;
    let increment = positive(road, "REFERENCE_LINE_INCREMENT", header.lines)?;
    let start = length(road, "REFERENCE_LINE_START_U")?.unwrap_or(0.0);
    let rows =
        length(road, "REFERENCE_LINE_END_U")?.map(|end| rows(road, end - start, increment)).transpose()?;
    let sections = sections(&header)?;
    let values = data::read(&header, &bytes[header.bytes..], rows)?;
    let columns = header.channels.len();
    let cuts = values.len() / columns;
    if cuts < 2 {
        return Err(Flaw::TooSmall { rows: cuts as u64, cols: sections.len() as u64 });
    }
    if (cuts - 1) as f64 * increment > FARTHEST {
        return Err(Flaw::TooLarge {
            found: cuts as u64,
            limit: (FARTHEST / increment) as u64,
            unit: "rows",
        });
    }
    let column = |wanted: Channel| header.channels.iter().position(|(c, _)| *c == wanted);
    let along = |wanted: Channel, first: usize| -> Result<Option<Vec<f64>>, Flaw> {
        let Some(k) = column(wanted) else { return Ok(None) };
        let own: Vec<f64> = values.iter().skip(k + first * columns).step_by(columns).copied().collect();
        let limit = if wanted == Channel::Heading { FARTHEST } else { STEEPEST };
        match own.iter().position(|v| v.is_nan() || v.abs() > limit) {
            Some(row) => Err(flaw(
                header.channels[k].1,
                format!("this channel has no usable value in row {} of the data", row + first + 1),
            )),
            None => Ok(Some(own)),
        }
    };
    let line = Line { road, cuts, increment };
    let headings = match along(Channel::Heading, 1)? {
        Some(headings) => headings,
        None => line.straight()?,
    };
    let modifiers = Modifiers::of(header.modifiers.as_ref(), &mut notes)?;
    let mut height = number(road, "REFERENCE_LINE_START_Z")?.unwrap_or(0.0);
    let slopes = match along(Channel::Slope, 1)? {
        Some(slopes) => slopes,
        None => vec![line.slope()?; cuts - 1],
    };
    let mut base = vec![height];
    base.extend(slopes.iter().map(|slope| {
        height += increment * slope * modifiers.slope;
        height
    }));
    let banking = match along(Channel::Banking, 0)? {
        Some(banking) => banking,
        None => vec![line.banking()?; cuts],
    };
    let banking = banking.iter().map(|b| b * modifiers.banking).collect();
    // Of a row the sections alone.
    let heights: Vec<usize> = header
        .channels
        .iter()
        .enumerate()
        .filter(|(_, (c, _))| matches!(c, Channel::Section(_) | Channel::At(_)))
        .map(|(k, _)| k)
        .collect();
    let mut grid = Vec::with_capacity(cuts * heights.len());
    let mut filled = 0;
    for (cut, row) in values.chunks_exact(columns).enumerate() {
        let first = grid.len();
        grid.extend(heights.iter().map(|k| row[*k] * modifiers.grid));
        filled += modifiers.fill(&mut grid[first..]).map_err(|problem| {
            let u = start + cut as f64 * increment;
            Flaw::Damaged(format!("the lateral cut at u = {u} m (row {} of the data) {problem}", cut + 1))
        })?;
    }
    if let Some(z) = grid.iter().chain(&base).find(|z| z.is_nan() || z.abs() > FARTHEST) {
        return Err(Flaw::Damaged(format!("a height of {z} m is invalid")));
    }
    if filled > 0 {
        notes.push(format!("{filled} heights at the borders are missing and filled in"));
    }
    let fade = options(&header.options, (cuts - 1) as f64 * increment, &mut notes)?;
    let origin = [
        length(road, "REFERENCE_LINE_START_X")?.unwrap_or(0.0),
        length(road, "REFERENCE_LINE_START_Y")?.unwrap_or(0.0),
    ];
    let course =
        Course::new(Parts { start, increment, sections, grid, headings, origin, base, banking, fade });
    line.check_end(&course, &mut notes)?;
    Ok(CourseFile { course, notes })
}

/// A number of a section; `None` if it is left out.
fn number(values: &Values, name: &str) -> Result<Option<f64>, Flaw> {
    Ok(values.get(name).map(|v| v.value))
}

/// A coordinate of a section, m.
fn length(values: &Values, name: &str) -> Result<Option<f64>, Flaw> {
    match values.get(name) {
        Some(Value { value, line }) if value.abs() > FARTHEST => {
            Err(flaw(*line, format!("{name} is {value}: at most {FARTHEST} m are allowed")))
        }
        found => Ok(found.map(|v| v.value)),
    }
}

/// A positive number that must be there. `last` is the last line of the header.
fn positive(values: &Values, name: &str, last: usize) -> Result<f64, Flaw> {
    match values.get(name) {
        None => Err(flaw(last, format!("the header ends without {name}: add it to $ROAD_CRG"))),
        Some(Value { value, .. }) if *value > 1e-6 && *value <= FARTHEST => Ok(*value),
        Some(Value { value, line }) => {
            Err(flaw(*line, format!("{name} is {value}: must be above 0, in metres")))
        }
    }
}

/// The number of lateral cuts over a length, m.
fn rows(road: &Values, length: f64, increment: f64) -> Result<usize, Flaw> {
    let line = road.get("REFERENCE_LINE_END_U").map_or(0, |v| v.line);
    let steps = length / increment;
    if !(steps >= 1.0 - AGREEMENT && (steps - steps.round()).abs() <= AGREEMENT * steps.max(1.0)) {
        return Err(flaw(
            line,
            format!(
                "REFERENCE_LINE_END_U is {length} m after the start, which is not a multiple of the increment, {increment} m"
            ),
        ));
    }
    if steps > MOST_BYTES as f64 {
        return Err(Flaw::TooLarge { found: steps as u64, limit: MOST_BYTES, unit: "rows" });
    }
    Ok(steps.round() as usize + 1)
}

/// The coordinates v of the sections, from right to left.
fn sections(header: &Header) -> Result<Vec<f64>, Flaw> {
    let road = &header.road;
    let found: Vec<(Channel, usize)> = header
        .channels
        .iter()
        .copied()
        .filter(|(c, _)| matches!(c, Channel::Section(_) | Channel::At(_)))
        .collect();
    for (k, (channel, line)) in header.channels.iter().enumerate() {
        if header.channels[..k].iter().any(|(before, _)| before == channel) {
            return Err(flaw(*line, "duplicate channel: remove one"));
        }
    }
    if found.len() < 2 {
        return Err(flaw(
            header.lines,
            format!("{} longitudinal sections are defined: a surface needs at least 2", found.len()),
        ));
    }
    let count = found.len();
    let (right, left) = (length(road, "LONG_SECTION_V_RIGHT")?, length(road, "LONG_SECTION_V_LEFT")?);
    let mut sections = Vec::with_capacity(count);
    if found.iter().all(|(c, _)| matches!(c, Channel::At(_))) {
        for (channel, line) in &found {
            let Channel::At(v) = *channel else { continue };
            if sections.last().is_some_and(|last| *last >= v) || v.abs() > FARTHEST {
                return Err(flaw(*line, format!("v = {v} must be above that of the section before it")));
            }
            sections.push(v);
        }
        for (name, given, own) in [("RIGHT", right, sections[0]), ("LEFT", left, sections[count - 1])] {
            if let Some(given) = given.filter(|g| (g - own).abs() > AGREEMENT) {
                let line = road.get(&format!("LONG_SECTION_V_{name}")).map_or(0, |v| v.line);
                return Err(flaw(
                    line,
                    format!("LONG_SECTION_V_{name} is {given}, but the last section there lies at v = {own}"),
                ));
            }
        }
        return Ok(sections);
    }
    for (k, (channel, line)) in found.iter().enumerate() {
        if *channel != Channel::Section(k as u32 + 1) {
            return Err(flaw(
                *line,
                format!("long section {} is expected here: number all of them from 1 on, or none", k + 1),
            ));
        }
    }
    let steps = (count - 1) as f64;
    let given = road.get("LONG_SECTION_V_INCREMENT").map(|v| (v.value, v.line));
    let increment = match (given, right, left) {
        (Some((increment, _)), _, _) => increment,
        (None, Some(right), Some(left)) => (left - right) / steps,
        _ => {
            return Err(flaw(
                header.lines,
                "the sections are numbered, but LONG_SECTION_V_INCREMENT is missing: add it to $ROAD_CRG",
            ));
        }
    };
    let line = given.map_or(header.lines, |g| g.1);
    if !(increment > 1e-6 && increment <= FARTHEST) {
        return Err(flaw(
            line,
            format!("the spacing of longitudinal sections is {increment} m: must be above 0"),
        ));
    }
    // Without a border the sections lie about the reference line.
    let first = match (right, left) {
        (Some(right), _) => right,
        (None, Some(left)) => left - steps * increment,
        (None, None) => -0.5 * steps * increment,
    };
    if let Some(left) =
        left.filter(|left| (first + steps * increment - left).abs() > AGREEMENT * (1.0 + left.abs()))
    {
        return Err(flaw(
            line,
            format!(
                "{count} sections with a spacing of {increment} m end at v = {} and not at LONG_SECTION_V_LEFT, {left}",
                first + steps * increment
            ),
        ));
    }
    Ok((0..count).map(|k| first + k as f64 * increment).collect())
}

/// Parameters of the reference line, for quantities without a channel.
struct Line<'a> {
    road: &'a Values,
    cuts: usize,
    increment: f64,
}

impl Line<'_> {
    /// Headings of a straight line, rad.
    fn straight(&self) -> Result<Vec<f64>, Flaw> {
        let at = |name: &str| number(self.road, &format!("REFERENCE_LINE_{name}"));
        let ends = |axis: &str| -> Result<Option<f64>, Flaw> {
            Ok(at(&format!("END_{axis}"))?
                .zip(Some(at(&format!("START_{axis}"))?.unwrap_or(0.0)))
                .map(|(b, a)| b - a))
        };
        let heading = match (at("START_PHI")?, ends("X")?, ends("Y")?) {
            (Some(heading), _, _) => heading,
            (None, Some(x), Some(y)) => vb_math::atan2(y, x),
            _ => 0.0,
        };
        if let Some(end) = self.road.get("REFERENCE_LINE_END_PHI")
            && vb_math::angle::wrap(end.value - heading).abs() > 1e-6
        {
            let problem = format!(
                "the heading goes from {heading} to {} rad, but there is no channel \"reference line phi\": add it",
                end.value
            );
            return Err(flaw(end.line, problem));
        }
        Ok(vec![heading; self.cuts - 1])
    }

    /// A value that is one from start to end.
    fn constant(&self, name: &str, channel: &str) -> Result<Option<f64>, Flaw> {
        let (start, end) = (format!("REFERENCE_LINE_START_{name}"), format!("REFERENCE_LINE_END_{name}"));
        let from = self.road.get(&start);
        if let Some(to) = self.road.get(&end)
            && (to.value - from.map_or(0.0, |v| v.value)).abs() > 1e-9
        {
            let problem = format!(
                "{end} is {} and {start} {}, but there is no channel \"reference line {channel}\": add it",
                to.value,
                from.map_or(0.0, |v| v.value)
            );
            return Err(flaw(to.line, problem));
        }
        match from {
            Some(Value { value, line }) if value.abs() > STEEPEST => {
                Err(flaw(*line, format!("{start} is {value}: at most {STEEPEST} is allowed")))
            }
            found => Ok(found.map(|v| v.value)),
        }
    }

    fn banking(&self) -> Result<f64, Flaw> {
        Ok(self.constant("B", "banking")?.unwrap_or(0.0))
    }

    /// The slope: as stated, or that between the heights of both ends.
    fn slope(&self) -> Result<f64, Flaw> {
        let stated = self.constant("S", "slope")?;
        let length = (self.cuts - 1) as f64 * self.increment;
        let ends = self.road.get("REFERENCE_LINE_START_Z").zip(self.road.get("REFERENCE_LINE_END_Z"));
        let between = ends.map(|(a, b)| (b.value - a.value) / length);
        match (stated, between, ends) {
            (Some(stated), Some(between), Some((_, end)))
                if (stated - between).abs() * length > AGREEMENT * (1.0 + length) =>
            {
                let problem = format!(
                    "REFERENCE_LINE_END_Z is {}, which contradicts the slope of {stated}: correct one of them",
                    end.value
                );
                Err(flaw(end.line, problem))
            }
            (Some(stated), _, _) => Ok(stated),
            (None, between, _) => Ok(between.unwrap_or(0.0)),
        }
    }

    /// Notes an end that is not the one of the parameters.
    fn check_end(&self, course: &Course, notes: &mut Vec<String>) -> Result<(), Flaw> {
        let at = |axis: &str| length(self.road, &format!("REFERENCE_LINE_END_{axis}"));
        let (Some(x), Some(y)) = (at("X")?, at("Y")?) else { return Ok(()) };
        let end = course.position(course.span()[1]).0;
        let off = vb_math::hypot(end[0] - x, end[1] - y);
        if off > AGREEMENT * course.length().max(1.0) {
            notes.push(format!(
                "the headings lead to ({:.3}, {:.3}) m instead of the end of the reference line in the file, ({x}, {y}) m",
                end[0], end[1]
            ));
        }
        Ok(())
    }
}

/// Factors of heights, and the values that replace missing ones.
#[derive(Debug)]
struct Modifiers {
    grid: f64,
    slope: f64,
    banking: f64,
    /// Whether missing heights at the borders are 0 instead of the last height of the cut, before `offset` (m) is added.
    level: bool,
    offset: f64,
}

impl Modifiers {
    fn of(values: Option<&Values>, notes: &mut Vec<String>) -> Result<Self, Flaw> {
        let mut own = Self { grid: 1.0, slope: 1.0, banking: 1.0, level: false, offset: 0.0 };
        for (name, Value { value, line }) in values.into_iter().flatten() {
            let refused = |what: &str| Err(flaw(*line, format!("{name} = {value} is not supported: {what}")));
            // A factor of 0 is none.
            let factor = if *value == 0.0 { 1.0 } else { *value };
            match name.as_str() {
                "SCALE_Z_GRID" => own.grid = factor,
                "SCALE_SLOPE" => own.slope = factor,
                "SCALE_BANKING" => own.banking = factor,
                "SCALE_LENGTH" | "SCALE_WIDTH" | "SCALE_CURVATURE" if factor != 1.0 => {
                    return refused("write a file with the scaled road");
                }
                "SCALE_LENGTH" | "SCALE_WIDTH" | "SCALE_CURVATURE" => {}
                "GRID_NAN_MODE" if *value == 1.0 => own.level = true,
                "GRID_NAN_MODE" if *value == 0.0 || *value == 2.0 => {}
                "GRID_NAN_MODE" => return refused("use 0, 1 or 2"),
                "GRID_NAN_OFFSET" => own.offset = *value,
                "REFLINE_OFFSET_Z" => {}
                moves if MOVES.contains(&moves) => {
                    notes.push(format!("{moves} moves the course as a whole and is not applied"));
                }
                _ => return refused("it is not a modifier of OpenCRG 1.2"),
            }
        }
        Ok(own)
    }

    /// Fills missing heights at the borders of a cut and returns their number.
    fn fill(&self, row: &mut [f64]) -> Result<usize, String> {
        let valid = |z: &f64| !z.is_nan();
        let (Some(first), Some(last)) = (row.iter().position(valid), row.iter().rposition(valid)) else {
            return Err("has no height at all".to_owned());
        };
        if row[first..=last].iter().any(|z| z.is_nan()) {
            return Err("lacks a height within the course; only borders are filled".to_owned());
        }
        let of = |z: f64| self.offset + if self.level { 0.0 } else { z };
        let (right, left) = (of(row[first]), of(row[last]));
        row[..first].fill(right);
        row[last + 1..].fill(left);
        Ok(first + row.len() - 1 - last)
    }
}

/// The lengths over which heights grow from 0 at the start and at the end, m.
fn options(values: &Values, length: f64, notes: &mut Vec<String>) -> Result<[f64; 2], Flaw> {
    let mut fade = [0.0; 2];
    for (name, Value { value, line }) in values {
        let refused = |what: &str| Err(flaw(*line, format!("{name} = {value} is not supported: {what}")));
        match name.as_str() {
            "BORDER_SMOOTH_UBEG" | "BORDER_SMOOTH_UEND" => {
                if !(0.0..=length).contains(value) {
                    return refused("must be from 0 to the length of the road, in metres");
                }
                fade[usize::from(name == "BORDER_SMOOTH_UEND")] = *value;
            }
            "BORDER_MODE_U" | "BORDER_MODE_V" if *value == 2.0 => {}
            "BORDER_MODE_U" | "BORDER_MODE_V" if *value == 0.0 => {
                notes.push(format!("{name} = 0: terrain outside the borders is level nevertheless"));
            }
            "BORDER_MODE_U" | "BORDER_MODE_V" => {
                return refused("use 0 or 2; terrain outside the borders is level");
            }
            "BORDER_OFFSET_U" | "BORDER_OFFSET_V" if *value == 0.0 => {}
            "BORDER_OFFSET_U" | "BORDER_OFFSET_V" => {
                return refused("use 0; terrain outside the borders is level");
            }
            "REFLINE_CONTINUATION" if *value == 0.0 => {}
            "REFLINE_CONTINUATION" => return refused("use 0; a closed track is read as an open one"),
            other if other.starts_with("WARN_") || other.starts_with("CHECK_") => {}
            _ => return refused("it is not an option of OpenCRG 1.2"),
        }
    }
    Ok(fade)
}
