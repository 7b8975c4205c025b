//! Formats of recordings.

use super::{Sample, Window};
use csv::{ReaderBuilder, StringRecord, Trim};
use vb_files::Flaw;

/// The columns of a file with a row for each moment.
const COLUMNS: [&str; 7] = ["window", "time", "left", "right", "x", "y", "yaw"];
/// The wheel speeds of DRIVE's tables, by sample: of the left and of the right side.
const DRIVE_SPEEDS: [&str; 2] = ["left_wheel_vel_", "right_wheel_vel_"];
/// The poses of DRIVE's tables: at the first sample, and one sample after the last.
const DRIVE_POSES: [[&str; 3]; 2] =
    [["init_icp_x", "init_icp_y", "init_icp_yaw"], ["gt_icp_x", "gt_icp_y", "gt_icp_yaw"]];
/// The interval between the samples of DRIVE's tables, s (Baril et al. 2023: 20 Hz).
const DRIVE_INTERVAL: f64 = 0.05;
/// Maximum magnitude of wheel speeds, rad/s, coordinates, m, angles, rad, and times, s.
const MOST: f64 = 1e6;
/// The longest window, s.
const LONGEST: f64 = 600.0;

/// The windows of a recording, and how many were left out since a value is missing in them.
pub(super) fn read(text: &str) -> Result<(Vec<Window>, usize), Flaw> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = ReaderBuilder::new().flexible(true).trim(Trim::All).from_reader(text.as_bytes());
    let unreadable = |e: &csv::Error| Flaw::new("file", e.to_string());
    let head = reader.headers().map_err(|e| unreadable(&e))?.clone();
    let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(|e| unreadable(&e))?;
    let (windows, incomplete) = if find(&head, &format!("{}0", DRIVE_SPEEDS[0])).is_some() {
        drive(&head, &rows)?
    } else {
        (moments(&head, &rows)?, 0)
    };
    if windows.is_empty() {
        let reason = if incomplete > 0 { "has a missing value in each row" } else { "has no rows" };
        return Err(Flaw::new("file", reason));
    }
    Ok((windows, incomplete))
}

fn find(head: &StringRecord, column: &str) -> Option<usize> {
    head.iter().position(|h| h == column)
}

fn number(text: &str, at: impl Fn() -> String) -> Result<f64, Flaw> {
    let value: f64 = text.parse().map_err(|_| Flaw::new(at(), format!("{text:?} is not a number")))?;
    if value.is_finite() && value.abs() <= MOST {
        return Ok(value);
    }
    Err(Flaw::new(at(), format!("{value} must lie in -{MOST} to {MOST}")))
}

fn line(row: &StringRecord) -> u64 {
    row.position().map_or(0, csv::Position::line)
}

/// The windows of a file with a row for each moment.
fn moments(head: &StringRecord, rows: &[StringRecord]) -> Result<Vec<Window>, Flaw> {
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = find(head, column).ok_or_else(|| {
            Flaw::new(
                "line 1",
                format!(
                    "has no column {column}; a recording has {}, or the columns of DRIVE",
                    COLUMNS.join(", ")
                ),
            )
        })?;
    }
    let mut windows: Vec<Window> = Vec::new();
    for row in rows {
        let at = |k: usize| format!("line {}, {}", line(row), COLUMNS[k]);
        let cell = |k: usize| {
            row.get(places[k]).ok_or_else(|| Flaw::new(at(k), "is missing: the line is too short"))
        };
        let number = |k: usize| number(cell(k)?, || at(k));
        let pose = match (cell(4)?.is_empty(), cell(5)?.is_empty(), cell(6)?.is_empty()) {
            (true, true, true) => None,
            _ => Some([number(4)?, number(5)?, number(6)?]),
        };
        let sample = Sample { time: number(1)?, sides: [number(2)?, number(3)?], pose };
        let name = cell(0)?;
        match windows.last_mut().filter(|w| w.name == name) {
            Some(w) => {
                let last = w.samples[w.samples.len() - 1].time;
                if sample.time <= last {
                    let reason = format!("{} must exceed that of the row before, {last}", sample.time);
                    return Err(Flaw::new(at(1), reason));
                }
                w.samples.push(sample);
            }
            None => windows.push(Window { name: name.to_owned(), samples: vec![sample] }),
        }
    }
    for w in &windows {
        let named = |problem: String| Err(Flaw::new(format!("window {}", w.name), problem));
        let [first, .., last] = w.samples[..] else {
            return named("has one row; at least two are needed".to_owned());
        };
        if first.pose.is_none() || last.pose.is_none() {
            return named("has no pose in its first or in its last row".to_owned());
        }
        if last.time - first.time > LONGEST {
            return named(format!("lasts {} s; at most {LONGEST} s", last.time - first.time));
        }
    }
    Ok(windows)
}

/// The windows of a table of DRIVE, and how many have missing values.
fn drive(head: &StringRecord, rows: &[StringRecord]) -> Result<(Vec<Window>, usize), Flaw> {
    let find = |column: &str| {
        let missing = || Flaw::new("line 1", format!("has no column {column}, which a table of DRIVE has"));
        find(head, column).ok_or_else(missing)
    };
    let mut speeds = Vec::new();
    while let Ok(left) = find(&format!("{}{}", DRIVE_SPEEDS[0], speeds.len())) {
        speeds.push([left, find(&format!("{}{}", DRIVE_SPEEDS[1], speeds.len()))?]);
    }
    let mut poses = [[0; 3]; 2];
    for (place, column) in poses.iter_mut().flatten().zip(DRIVE_POSES.iter().flatten()) {
        *place = find(column)?;
    }
    if speeds.len() as f64 * DRIVE_INTERVAL > LONGEST {
        let reason = format!("has {} samples in a window; at most {LONGEST} s at 20 Hz", speeds.len());
        return Err(Flaw::new("line 1", reason));
    }
    let window = |row: &StringRecord| -> Result<Option<Window>, Flaw> {
        let number = |place: usize| {
            let text = row.get(place).unwrap_or_default();
            // What pandas writes where it has no number, and what others do.
            if text.is_empty() || text.eq_ignore_ascii_case("nan") {
                return Ok(None);
            }
            number(text, || format!("line {}, {}", line(row), &head[place])).map(Some)
        };
        let mut ends = [[0.0; 3]; 2];
        for (value, place) in ends.iter_mut().flatten().zip(poses.iter().flatten()) {
            let Some(read) = number(*place)? else { return Ok(None) };
            *value = read;
        }
        let mut samples = Vec::with_capacity(speeds.len() + 1);
        for (k, [left, right]) in speeds.iter().enumerate() {
            let (Some(left), Some(right)) = (number(*left)?, number(*right)?) else { return Ok(None) };
            samples.push(Sample { time: k as f64 * DRIVE_INTERVAL, sides: [left, right], pose: None });
        }
        // The speeds of the last sample last until the last pose.
        samples.extend(samples.last().map(|last| Sample { time: last.time + DRIVE_INTERVAL, ..*last }));
        let [first, .., last] = &mut samples[..] else { return Ok(None) };
        (first.pose, last.pose) = (Some(ends[0]), Some(ends[1]));
        Ok(Some(Window { name: format!("line {}", line(row)), samples }))
    };
    let windows: Vec<Window> =
        rows.iter().filter_map(|row| window(row).transpose()).collect::<Result<_, _>>()?;
    let incomplete = rows.len() - windows.len();
    Ok((windows, incomplete))
}
