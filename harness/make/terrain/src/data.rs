//! A folder of elevation data as a model learns from it: which parts of which files, repaired, levelled, at the model's
//! resolution.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;
use vb_files::Hash;

use crate::ElevationImage;
use crate::read::{self, Holes, ReadError};
use crate::repair::{Repaired, fill, repair};

/// Name of the file in a folder of data that says which parts of it to use.
pub const SELECTION: &str = "terrain.yaml";
/// Without a selection, every so many-th file is held out.
const HELD_OUT: usize = 8;

/// Why a folder of elevation data can't be learned from.
#[derive(Debug, Error)]
pub enum DataError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("{}: {problem}", path.display())]
    Folder { path: PathBuf, problem: String },
}

/// Which parts of a folder to use (`terrain.yaml`).
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// Version of this format: 1.
    pub schema: u32,
    /// Lowest and highest value that is a measurement; others are holes.
    #[serde(default)]
    pub valid: Option<[f64; 2]>,
    /// The files to use, by name.
    pub files: BTreeMap<String, Part>,
}

/// Which part of a file to use.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Columns and rows `[west, north, east, south]`, the last two excluded; left out: all.
    #[serde(default)]
    pub window: Option<[usize; 4]>,
    /// Whether the model is tested on it rather than trained.
    #[serde(default)]
    pub held_out: bool,
}

/// How heights and places of the files are meant.
#[derive(Clone, Copy, Debug)]
pub struct Meaning {
    /// Distance between samples in metres, where a file doesn't say it.
    pub resolution: f64,
    /// Every so many-th sample of a file, along each side, is one of the model's.
    pub every: usize,
}

/// One file's part, ready to be learned from.
#[derive(Clone, Debug)]
pub struct Scan {
    pub name: String,
    /// Whether it is held out from training.
    pub held_out: bool,
    pub repaired: Repaired,
    /// Its samples at the model's resolution, once for each place that they can begin at.
    pub layers: Vec<Layer>,
}

/// Samples at the model's resolution, without holes, and which of them were measured.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Heights in units of [`Data::std`], holes filled.
    pub heights: ElevationImage,
    /// Which samples are measurements.
    pub measured: Vec<bool>,
}

/// All that a model learns from.
#[derive(Clone, Debug)]
pub struct Data {
    /// The files' parts, in the order of their names.
    pub scans: Vec<Scan>,
    /// Standard deviation of the measured heights that are trained on, about each part's own plane, in the files' unit.
    pub std: f64,
    /// Distance between the model's samples, m.
    pub resolution: f64,
    /// SHA-256 over the names and bytes of the files used and of the selection.
    pub sha256: String,
}

impl Data {
    /// Reads a folder; `selection` is a file that says which parts to use, by default `terrain.yaml` in it.
    ///
    /// # Errors
    /// [`DataError`] if nothing in it can be used, or a file that should be can't.
    pub fn read(dir: &Path, selection: Option<&Path>, meaning: Meaning) -> Result<Self, DataError> {
        let mut hash = Hash::new();
        let selection = read_selection(dir, selection, &mut hash)?;
        let mut names: Vec<String> = std::fs::read_dir(dir)
            .map_err(|e| folder(dir, e))?
            .flatten()
            .filter(|e| {
                let path = e.path();
                let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
                ["bmp", "png", "npy", "tif", "tiff"].contains(&ending.as_str())
            })
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        if let Some(s) = &selection {
            if let Some(missing) = s.files.keys().find(|name| !names.contains(name)) {
                return Err(folder(dir, format!("{missing} of the selection does not exist")));
            }
            names.retain(|name| s.files.contains_key(name));
        }
        if names.is_empty() {
            return Err(folder(dir, "contains no elevation data (.bmp, .png, .npy, .tif or .tiff)"));
        }
        let mut raw = Vec::new();
        let mut resolution = None;
        for (i, name) in names.iter().enumerate() {
            let path = dir.join(name);
            let part = match &selection {
                Some(s) => s.files.get(name).copied().unwrap_or_default(),
                None => Part { window: None, held_out: i % HELD_OUT == HELD_OUT - 1 },
            };
            let mut raster = read::read(&path, Holes::Keep)?;
            let bytes = vb_files::read(&path, vb_files::DATA).map_err(|e| folder(&path, e))?;
            hash.update(name.as_bytes());
            hash.update([0]);
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(&bytes);
            let own = raster.resolution().unwrap_or(meaning.resolution) * meaning.every as f64;
            match resolution {
                None => resolution = Some(own),
                Some(p) if (own - p).abs() <= 1e-3 * p => {}
                Some(p) => {
                    return Err(folder(
                        &path,
                        format!(
                            "the sample spacing is {own} m, in previous files {p} m: resample them to one resolution"
                        ),
                    ));
                }
            }
            if let Some([west, north, east, south]) = part.window {
                if west >= east || north >= south || east > raster.cols() || south > raster.rows() {
                    return Err(folder(
                        &path,
                        format!(
                            "window [{west}, {north}, {east}, {south}] is not within its {} columns and {} rows",
                            raster.cols(),
                            raster.rows()
                        ),
                    ));
                }
                raster = raster.window(north, west, south - north, east - west);
            }
            if let Some([low, high]) = selection.as_ref().and_then(|s| s.valid) {
                for v in raster.values_mut() {
                    if !(low..=high).contains(v) {
                        *v = f64::NAN;
                    }
                }
            }
            let repaired = repair(&mut raster);
            raster.level();
            raw.push((name.clone(), part.held_out, repaired, raster));
        }
        let std = spread(raw.iter().filter(|(_, held_out, ..)| !held_out).map(|(.., r)| r));
        if std <= 0.0 || !std.is_finite() {
            return Err(folder(dir, "heights are constant, so there is nothing to learn"));
        }
        let scans = raw
            .into_iter()
            .map(|(name, held_out, repaired, raster)| Scan {
                name,
                held_out,
                repaired,
                layers: layers(&raster, meaning.every, std),
            })
            .collect();
        let sha256 = hash.hex();
        Ok(Self { scans, std, resolution: resolution.unwrap_or(meaning.resolution), sha256 })
    }
}

fn folder(path: &Path, problem: impl std::fmt::Display) -> DataError {
    DataError::Folder { path: path.to_owned(), problem: vb_files::one_line(&problem.to_string()) }
}

fn read_selection(dir: &Path, given: Option<&Path>, hash: &mut Hash) -> Result<Option<Selection>, DataError> {
    let own = dir.join(SELECTION);
    let path = match given {
        Some(path) => path,
        None if own.is_file() => &own,
        None => return Ok(None),
    };
    let text = vb_files::read_text(path, vb_files::DOCUMENT).map_err(|e| folder(path, e))?;
    hash.update(text.replace("\r\n", "\n").as_bytes());
    let selection: Selection = serde_yaml::from_str(&text).map_err(|e| folder(path, e))?;
    if selection.schema != 1 {
        return Err(folder(path, format!("schema {}: must be 1", selection.schema)));
    }
    Ok(Some(selection))
}

/// Standard deviation of the measured heights of levelled rasters.
fn spread<'a>(rasters: impl Iterator<Item = &'a ElevationImage>) -> f64 {
    let (mut n, mut squares) = (0.0, 0.0);
    for raster in rasters {
        for v in raster.values().iter().filter(|v| !v.is_nan()) {
            n += 1.0;
            squares += v * v;
        }
    }
    if n > 0.0 { (squares / n).sqrt() } else { 0.0 }
}

/// The raster's samples at the model's resolution, once for each place where they can begin.
fn layers(raster: &ElevationImage, every: usize, std: f64) -> Vec<Layer> {
    let mut layers = Vec::new();
    for row in 0..every.min(raster.rows()) {
        for col in 0..every.min(raster.cols()) {
            let mut heights = raster.thinned(row, col, every);
            let measured = heights.values().iter().map(|v| !v.is_nan()).collect();
            fill(&mut heights);
            for v in heights.values_mut() {
                *v /= std;
            }
            layers.push(Layer { heights, measured });
        }
    }
    layers
}
