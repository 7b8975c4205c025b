//! From samples as they lie in a file to heights in metres on a square grid with its first row in the north.

use crate::ElevationImage;
use crate::crs::{Crs, Length};
use crate::utm::Zone;

use super::survey::{Options, Place, Said, Survey, short};
use super::{Flaw, Holes, MAX_SAMPLES, check_size, suspect};

/// Sides of a pixel that differ by less are equal.
const SQUARE: f64 = 1e-3;
/// A system whose metres differ by less from those on the ground is taken at its word.
const TRUE_SCALE: f64 = 0.01;
/// Samples between places whose projection is computed; it is linear between them to some thousandths of a sample.
const COARSE: usize = 32;
/// Degrees from a central meridian within which a zone of UTM is used.
const ZONE: f64 = 6.0;

/// How the samples of a file lie: coordinates of a sample's middle are `origin + column · right + row · down`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lay {
    /// The middle of the first sample; `None` if only distances are known.
    pub(super) origin: Option<[f64; 2]>,
    pub(super) right: [f64; 2],
    pub(super) down: [f64; 2],
}

impl Lay {
    /// North-up pixels of this size, from the middle of the north-western one.
    pub(super) fn north_up(origin: Option<[f64; 2]>, [width, height]: [f64; 2]) -> Self {
        Self { origin, right: [width, 0.0], down: [0.0, -height] }
    }
}

pub(super) struct Found {
    pub(super) format: &'static str,
    /// Values as the file has them.
    pub(super) raster: ElevationImage,
    /// Samples that the file marks as not measured, row-major; empty where there are none.
    pub(super) no_data: Vec<bool>,
    /// Heights are values times the first plus the second.
    pub(super) scale: [f64; 2],
    /// The unit of heights, where the file says so.
    pub(super) unit: Option<Length>,
    pub(super) lay: Option<Lay>,
    pub(super) crs: Option<Crs>,
    /// Whether values can be marks of no data that aren't declared; not so in pictures.
    pub(super) suspects: bool,
    pub(super) notes: Vec<String>,
}

impl Found {
    /// Plain values without any place.
    pub(super) fn plain(format: &'static str, raster: ElevationImage) -> Self {
        Self {
            format,
            raster,
            no_data: Vec::new(),
            scale: [1.0, 0.0],
            unit: None,
            lay: None,
            crs: None,
            suspects: true,
            notes: Vec::new(),
        }
    }
}

/// Makes a survey of what was found.
pub(super) fn finish(found: Found, options: &Options) -> Result<Survey, Flaw> {
    let Found { format, mut raster, mut no_data, scale, unit, lay, crs, suspects, mut notes } = found;
    let samples = [raster.rows(), raster.cols()];
    if let Some(mark) = options.no_data {
        no_data.resize(raster.values().len(), false);
        let single = |v: f64| v as f32 == mark as f32;
        for (hole, v) in no_data.iter_mut().zip(raster.values()) {
            *hole |= *v == mark || single(*v) || (v.is_nan() && mark.is_nan());
        }
    }
    mark_holes(&mut raster, &no_data, options.holes)?;
    drop(no_data);
    let looked_for = suspects && !options.keep && !options.labels;
    let mut suspect = None;
    // Of several marks one is found after the other.
    while let Some(value) = looked_for.then(|| suspect::find(raster.values())).flatten() {
        suspect = Some(value);
        let count = suspect::mark(raster.values_mut(), value);
        if options.holes == Holes::Refuse {
            return Err(Flaw::Unmarked { value, count });
        }
        notes.push(format!(
            "{count} samples of {} are far from all others and are treated as unmarked no data: mark them with --no-data {}, or \
             keep them as heights with --keep-values",
            short(value), short(value)
        ));
    }
    let (unit, unit_said) = unit_of(unit, &crs, options, &mut notes);
    if !options.labels {
        to_metres(&mut raster, scale, unit.metres);
    }
    let crs = match (&options.crs, crs) {
        (Some(given), Some(own)) if own.name != given.name => {
            notes.push(format!("the file says {}, but {} was given", own.name, given.name));
            options.crs.clone()
        }
        (Some(_), _) => options.crs.clone(),
        (None, own) => own.or_else(|| lay.as_ref().and_then(|lay| guess(lay, samples, &mut notes))),
    };
    let (raster, lay, orientation) = turn(raster, lay)?;
    let (heights, place) = lay_out(raster, lay, crs, options, &mut notes)?;
    Ok(Survey { heights, format, samples, unit, unit_said, orientation, place, notes, suspect })
}

/// Refuses or marks what is no height.
fn mark_holes(raster: &mut ElevationImage, no_data: &[bool], holes: Holes) -> Result<(), Flaw> {
    let cols = raster.cols();
    if holes == Holes::Refuse {
        let count = no_data.iter().filter(|hole| **hole).count();
        if let Some(i) = no_data.iter().position(|hole| *hole) {
            return Err(Flaw::NoData { count, row: i / cols, col: i % cols });
        }
        let odd = |v: &f64| !v.is_finite();
        if let Some(i) = raster.values().iter().position(odd) {
            let count = raster.values().iter().filter(|v| odd(v)).count();
            return Err(Flaw::NotFinite { count, row: i / cols, col: i % cols });
        }
    }
    for (i, v) in raster.values_mut().iter_mut().enumerate() {
        if !v.is_finite() || no_data.get(i) == Some(&true) {
            *v = f64::NAN;
        }
    }
    Ok(())
}

/// The unit of heights: the caller's, the file's, that of a compound system, that of coordinates in feet, or the metre.
fn unit_of(
    own: Option<Length>,
    crs: &Option<Crs>,
    options: &Options,
    notes: &mut Vec<String>,
) -> (Length, Said) {
    let own = own.or_else(|| crs.as_ref()?.heights.clone());
    if let Some(metres) = options.unit {
        let odd = own.filter(|own| (own.metres / metres - 1.0).abs() > 1e-6);
        if let Some(own) = odd {
            notes.push(format!(
                "the file says that heights are in {}, but a unit of {} m was given",
                own.name,
                short(metres)
            ));
        }
        return (Length::of(metres), Said::Caller);
    }
    let system = options.crs.as_ref().or(crs.as_ref());
    match own {
        Some(own) => (own, Said::File),
        None => match system.filter(|crs| !crs.geographic).map(|crs| Length::of(crs.unit)) {
            Some(feet) if (0.29..0.32).contains(&feet.metres) => (feet, Said::Assumed("as the coordinates")),
            _ => (Length::metre(), Said::Assumed("")),
        },
    }
}

/// Factors of one and offsets of zero leave every bit as it is.
fn to_metres(raster: &mut ElevationImage, [scale, offset]: [f64; 2], metres: f64) {
    if [scale, offset, metres] == [1.0, 0.0, 1.0] {
        return;
    }
    for v in raster.values_mut() {
        *v = (*v * scale + offset) * metres;
    }
}

/// Degrees, if coordinates can be nothing else: pixels that are too small for a survey in metres, at places on the globe.
fn guess(lay: &Lay, [rows, cols]: [usize; 2], notes: &mut Vec<String>) -> Option<Crs> {
    let first = lay.origin?;
    let last = |i: usize| first[i] + (cols - 1) as f64 * lay.right[i] + (rows - 1) as f64 * lay.down[i];
    let small = |v: [f64; 2]| vb_math::hypot(v[0], v[1]) < 0.05;
    let on_globe = [first[0], last(0)].iter().all(|v| v.abs() <= 360.0)
        && [first[1], last(1)].iter().all(|v| v.abs() <= 90.0);
    if !(small(lay.right) && small(lay.down) && on_globe) {
        return None;
    }
    notes.push("coordinates look like degrees without a coordinate system: WGS 84 (EPSG:4326) is assumed; give another with --crs".into());
    Some(Crs::wgs84())
}

/// The raster with its first row in the north and its first column in the west.
fn turn(
    raster: ElevationImage,
    lay: Option<Lay>,
) -> Result<(ElevationImage, Option<Lay>, &'static str), Flaw> {
    let Some(Lay { mut origin, mut right, mut down }) = lay else {
        return Ok((raster, None, "first row in the north (assumed)"));
    };
    let sides = [vb_math::hypot(right[0], right[1]), vb_math::hypot(down[0], down[1])];
    if !sides.iter().all(|s| s.is_finite() && *s > 0.0) {
        return Err(Flaw::Coordinates(format!(
            "the pixel size {} x {} is invalid: restore the file",
            sides[0], sides[1]
        )));
    }
    // A pixel at the far end must not be off by a tenth of one.
    let (rows, cols) = (raster.rows(), raster.cols());
    let off = (right[1].abs() / sides[1] * cols as f64).max(down[0].abs() / sides[0] * rows as f64);
    if off > 0.1 {
        let angle = vb_math::atan2(right[1], right[0]).to_degrees();
        return Err(Flaw::Coordinates(format!(
            "its rows don't run west to east (rotated by {angle:.1} degrees or sheared): straighten it with gdalwarp -r bilinear IN OUT.tif"
        )));
    }
    let mut raster = raster;
    let (west, south) = (right[0] < 0.0, down[1] > 0.0);
    if south {
        raster.flip_rows();
        let n = (rows - 1) as f64;
        origin = origin.map(|o| [o[0] + n * down[0], o[1] + n * down[1]]);
        down = [-down[0], -down[1]];
    }
    if west {
        raster.flip_cols();
        let n = (cols - 1) as f64;
        origin = origin.map(|o| [o[0] + n * right[0], o[1] + n * right[1]]);
        right = [-right[0], -right[1]];
    }
    let orientation = match (south, west) {
        (false, false) => "north-up",
        (true, false) => "south-up (turned to north-up)",
        (false, true) => "east-left (mirrored to north-up)",
        (true, true) => "south-up and east-left (turned to north-up)",
    };
    Ok((raster, Some(Lay { origin, right, down }), orientation))
}

/// The raster on a square grid of metres, and where it lies.
fn lay_out(
    raster: ElevationImage,
    lay: Option<Lay>,
    crs: Option<Crs>,
    options: &Options,
    notes: &mut Vec<String>,
) -> Result<(ElevationImage, Option<Place>), Flaw> {
    let Some(lay) = lay else {
        if options.crs.is_some() {
            notes.push(
                "the file has no position, so the given coordinate reference system has no effect".into(),
            );
        }
        return Ok((raster.with_resolution(options.resolution), None));
    };
    let (rows, cols) = (raster.rows(), raster.cols());
    let to = |right: f64, down: f64, o: [f64; 2]| {
        [o[0] + right * lay.right[0] + down * lay.down[0], o[1] + right * lay.right[1] + down * lay.down[1]]
    };
    let centre = [0.5 * (cols - 1) as f64, 0.5 * (rows - 1) as f64];
    let middle = lay.origin.map(|o| to(centre[0], centre[1], o));
    if let Some(system) = crs.as_ref().filter(|crs| crs.geographic) {
        let Some(origin) = lay.origin else {
            return Err(Flaw::Coordinates(
                "coordinates are degrees, but the file has no position: add a georeference".into(),
            ));
        };
        return projected(&raster, &lay, origin, system, options, notes);
    }
    let unit = crs.as_ref().map_or(1.0, |crs| crs.unit);
    let mut metres = [unit; 2];
    if let (Some(crs), Some(middle)) = (&crs, middle)
        && let Some(ground) = crs.ground(middle)
        && ground.iter().any(|g| (g / unit - 1.0).abs() > TRUE_SCALE)
    {
        let of = short((ground[0] * ground[1]).sqrt());
        if crs.is_for_maps() {
            metres = ground;
            notes.push(format!(
                "a unit of {} is {of} m on the ground here: distances are those on the ground",
                crs.name
            ));
        } else {
            notes.push(format!(
                "a unit of {} is {of} m on the ground here, but {} m is used: check that the survey is in the area of this system",
                crs.name,
                short(unit)
            ));
        }
    }
    let place = middle.map(|middle| Place { crs, middle, metres });
    if let Some(resolution) = options.resolution {
        let own = lay.right[0] * metres[0];
        if (own / resolution - 1.0).abs() > SQUARE {
            notes.push(format!(
                "the file says {} m between samples, but {resolution} m was given",
                short(own)
            ));
            let place = place.map(|p| Place {
                metres: [lay.right[0] / resolution, -lay.down[1] / resolution].map(f64::recip),
                ..p
            });
            return Ok((raster.with_resolution(Some(resolution)), place));
        }
        return Ok((raster.with_resolution(Some(resolution)), place));
    }
    let [x, y] = [lay.right[0] * metres[0], -lay.down[1] * metres[1]];
    if (x - y).abs() <= SQUARE * x.max(y) {
        return Ok((raster.with_resolution(Some(x)), place));
    }
    let side = x.min(y);
    let size =
        |n: usize, own: f64| (((n - 1) as f64 * own / side * (1.0 + 1e-12)).floor() as u64).saturating_add(1);
    let (rows_out, cols_out) = (size(rows, y), size(cols, x));
    check_size(rows_out, cols_out)?;
    notes.push(format!(
        "pixels of {} x {} m were resampled to squares of {} m",
        short(x),
        short(y),
        short(side)
    ));
    let (rows_out, cols_out) = (rows_out as usize, cols_out as usize);
    let half = [0.5 * (rows_out - 1) as f64, 0.5 * (cols_out - 1) as f64];
    let heights = sampled(&raster, rows_out, cols_out, options.labels, |r, c| {
        [centre[1] + (r - half[0]) * side / y, centre[0] + (c - half[1]) * side / x]
    });
    Ok((heights.with_resolution(Some(side)), place))
}

/// A raster of degrees on a grid of its zone of UTM, about its middle.
fn projected(
    raster: &ElevationImage,
    lay: &Lay,
    origin: [f64; 2],
    system: &Crs,
    options: &Options,
    notes: &mut Vec<String>,
) -> Result<(ElevationImage, Option<Place>), Flaw> {
    let (rows, cols) = (raster.rows(), raster.cols());
    let step = [lay.right[0] * system.unit, -lay.down[1] * system.unit];
    let origin = origin.map(|v| v * system.unit);
    let last = [origin[0] + (cols - 1) as f64 * step[0], origin[1] - (rows - 1) as f64 * step[1]];
    let middle = [0.5 * (origin[0] + last[0]), 0.5 * (origin[1] + last[1])];
    let zone = Zone::of(middle[0], middle[1], system.ellipsoid())
        .filter(|_| origin.iter().chain(&last).all(|v| v.is_finite()));
    let Some(zone) = zone else {
        if [origin[1], last[1]].iter().any(|lat| lat.abs() > 90.5) {
            return Err(Flaw::Coordinates(format!(
                "its coordinates are degrees ({}), but reach from latitude {} to {}: its position or its coordinate system is wrong (give one \
                 with --crs)",
                system.name,
                short(last[1]),
                short(origin[1])
            )));
        }
        return Err(Flaw::Coordinates(format!(
            "is at latitude {}, outside the UTM zones: reproject it with gdalwarp -t_srs EPSG:CODE -r bilinear IN OUT.tif",
            short(middle[1])
        )));
    };
    let turned = |lon: f64| {
        let turns = (lon - zone.central_meridian()) / 360.0;
        (360.0 * (turns - turns.round())).abs()
    };
    if turned(origin[0]).max(turned(last[0])) > ZONE || origin[1].abs().max(last[1].abs()) > 85.0 {
        return Err(Flaw::Coordinates(format!(
            "covers {} x {} degrees, too large for one UTM zone: cut a part with gdal_translate -projwin WEST NORTH EAST SOUTH IN OUT.tif",
            short(cols as f64 * step[0]),
            short(rows as f64 * step[1])
        )));
    }
    let [east, north] = zone.project(middle);
    let beside = zone.project([middle[0] + 0.5 * step[0], middle[1]]);
    let above = zone.project([middle[0], middle[1] + 0.5 * step[1]]);
    let far = |p: [f64; 2]| 2.0 * vb_math::hypot(p[0] - east, p[1] - north);
    let (x, y) = (far(beside), far(above));
    // Meridians narrow: the finer side decides, as far as the samples are not many times more.
    let side = options.resolution.unwrap_or_else(|| three_digits(x.min(y).max(0.5 * (x * y).sqrt())));
    if !(side.is_finite() && side > 0.0) {
        return Err(Flaw::Coordinates(format!(
            "the pixel size {} x {} degrees is invalid: restore the file",
            step[0], step[1]
        )));
    }
    let corners = [origin, [last[0], origin[1]], last, [origin[0], last[1]]].map(|p| zone.project(p));
    let reach = |i: usize, centre: f64| corners.iter().map(|p| (p[i] - centre).abs()).fold(0.0, f64::max);
    let size = |i: usize, centre: f64| {
        ((reach(i, centre) / side).floor() as u64).saturating_mul(2).saturating_add(1)
    };
    let (rows_out, cols_out) = (size(1, north), size(0, east));
    check_size(rows_out, cols_out)?;
    if rows_out * cols_out > 16 * (rows as u64 * cols as u64) + (1 << 20) {
        return Err(Flaw::TooLarge {
            found: rows_out * cols_out,
            limit: MAX_SAMPLES.min(16 * (rows * cols) as u64),
            unit: "samples after the projection",
        });
    }
    let crs = system.utm(zone.number, zone.south);
    notes.push(format!(
        "degrees ({}) were projected to UTM zone {}{} ({}): pixels of {} x {} m, resampled to {} m",
        system.name,
        zone.number,
        if zone.south { 'S' } else { 'N' },
        crs.name,
        short(x),
        short(y),
        short(side)
    ));
    let (rows_out, cols_out) = (rows_out as usize, cols_out as usize);
    let half = [0.5 * (rows_out - 1) as f64, 0.5 * (cols_out - 1) as f64];
    let place = |r: usize, c: usize| {
        let at = [east + (c as f64 - half[1]) * side, north - (r as f64 - half[0]) * side];
        let [lon, lat] = zone.unproject(at);
        let turns = (lon - middle[0]) / 360.0;
        let lon = middle[0] + 360.0 * (turns - turns.round());
        [(origin[1] - lat) / step[1], (lon - origin[0]) / step[0]]
    };
    let (down, across) = (rows_out.div_ceil(COARSE) + 1, cols_out.div_ceil(COARSE) + 1);
    let coarse: Vec<[f64; 2]> =
        (0..down * across).map(|i| place(i / across * COARSE, i % across * COARSE)).collect();
    let heights = sampled(raster, rows_out, cols_out, options.labels, |r, c| {
        let (v, u) = (r / COARSE as f64, c / COARSE as f64);
        let (r0, c0) = (v as usize, u as usize);
        let (v, u) = (v - r0 as f64, u - c0 as f64);
        let at = |r: usize, c: usize| coarse[r.min(down - 1) * across + c.min(across - 1)];
        let (nw, ne, sw, se) = (at(r0, c0), at(r0, c0 + 1), at(r0 + 1, c0), at(r0 + 1, c0 + 1));
        [0, 1].map(|k| (1.0 - v) * ((1.0 - u) * nw[k] + u * ne[k]) + v * ((1.0 - u) * sw[k] + u * se[k]))
    });
    let place = Place { crs: Some(crs), middle: [east, north], metres: [1.0; 2] };
    Ok((heights.with_resolution(Some(side)), Some(place)))
}

/// A positive number rounded down to three significant digits.
fn three_digits(v: f64) -> f64 {
    let text = format!("{v:.8e}");
    let Some((digits, exponent)) = text.split_once('e') else { return v };
    format!("{}e{exponent}", &digits[..digits.len().min(4)]).parse().unwrap_or(v)
}

/// A raster of the samples at places (row, column) of another one, by the four around them or the nearest one. NaN beside holes and
/// beyond the outermost samples.
fn sampled(
    from: &ElevationImage,
    rows: usize,
    cols: usize,
    nearest: bool,
    place: impl Fn(f64, f64) -> [f64; 2],
) -> ElevationImage {
    let mut values = Vec::with_capacity(rows * cols);
    let inside = |v: f64, n: usize| (-0.5..=n as f64 - 0.5).contains(&v);
    for r in 0..rows {
        for c in 0..cols {
            let [row, col] = place(r as f64, c as f64);
            if !(inside(row, from.rows()) && inside(col, from.cols())) {
                values.push(f64::NAN);
                continue;
            }
            if nearest {
                let index = |v: f64, n: usize| ((v + 0.5).max(0.0) as usize).min(n - 1);
                values.push(from.at(index(row, from.rows()), index(col, from.cols())));
                continue;
            }
            values.push(from.between(row, col));
        }
    }
    ElevationImage::new(rows, cols, values)
}
