//! `vb-harness suite import` and `suite site`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::positive;

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// BenchMaps folder of the original benchmark, or a parent folder
    #[arg(value_name = "DIR")]
    pub(crate) from: PathBuf,
    /// Directory for the suite
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Terrain to build: as described by paper and labels, or as simulated by the original's code
    #[arg(long, value_name = "GROUND", value_enum, default_value_t)]
    pub(crate) ground: Ground,
}

/// Which ground an import makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Ground {
    /// Friction and soil per patch, obstacles on the ground.
    #[default]
    AsDescribed,
    /// Friction per merged section, soil in bands and rectangles, obstacles as boxes at their stored height.
    AsSimulated,
}

impl From<Ground> for vb_suite::import::Ground {
    fn from(ground: Ground) -> Self {
        match ground {
            Ground::AsDescribed => Self::AsDescribed,
            Ground::AsSimulated => Self::AsSimulated,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct SiteArgs {
    /// Elevation raster: GeoTIFF, ESRI grid (.asc, .bil, .flt), SRTM tile (.hgt), NumPy (.npy, .npz), PNG or BMP; or a course (OpenCRG,
    /// .crg); detected by content
    #[arg(value_name = "RASTER")]
    pub(crate) raster: PathBuf,
    /// Directory for the suite
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Distance between the raster's samples, m; default: from the file
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) sample_resolution: Option<f64>,
    /// Metres per unit of the raster's values, e.g. per grey level; default: the file's unit, or 1
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) unit: Option<f64>,
    /// Value of places without a height; default: from the file
    #[arg(long, value_name = "VALUE", value_parser = any_number, allow_hyphen_values = true)]
    pub(crate) no_data: Option<f64>,
    /// Keep values that look like unmarked no-data values, e.g. a single -9999, as heights
    #[arg(long)]
    pub(crate) keep_values: bool,
    /// Accept a relief too high or too steep for driving, which otherwise counts as a wrong unit
    #[arg(long)]
    pub(crate) any_relief: bool,
    /// Coordinate reference system of the raster, e.g. EPSG:32632; default: from the file
    #[arg(long, value_name = "EPSG:CODE", value_parser = system, allow_hyphen_values = true)]
    pub(crate) crs: Option<vb_terrain::crs::Crs>,
    /// Centre of the single world, m east and north of the raster's middle
    #[arg(long, value_name = "X,Y", default_value = "0,0", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) at: [f64; 2],
    /// Make as many adjacent worlds as fit
    #[arg(long, conflicts_with = "at")]
    pub(crate) tiles: bool,
    /// Raster of terrain classes over the same rectangle; the legend is in the rules of --site
    #[arg(long, value_name = "RASTER")]
    pub(crate) labels: Option<PathBuf>,
    /// Obstacles in the format of a world's obstacles.yaml, relative to the raster's middle; default: random obstacles
    #[arg(long, value_name = "FILE")]
    pub(crate) obstacles: Option<PathBuf>,
    /// Number of random obstacles: sparse, medium or dense; with --obstacles, the density label of the suite
    #[arg(long, value_name = "DENSITY", default_value = "sparse", value_parser = density)]
    pub(crate) density: vb_world::Density,
    /// Rules for grid and terrain classes; default: tasks/generator/site.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) site: Option<PathBuf>,
    /// Generator rules for friction, starts, obstacles, tasks and paths; default: tasks/generator/default.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
    /// Random seed; equal options and seeds give equal bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
}

/// Two numbers, x and y.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let both = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    both.ok_or_else(|| format!("{text:?} is not two numbers, e.g. 120,-35.5"))
}

/// A number, which may be NaN.
fn any_number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().map_err(|_| format!("{text:?} is not a number, e.g. -9999 or nan"))
}

/// A coordinate reference system.
fn system(text: &str) -> Result<vb_terrain::crs::Crs, String> {
    vb_terrain::crs::Crs::parse(text)
}

/// The name of a density.
fn density(text: &str) -> Result<vb_world::Density, String> {
    let found = vb_world::Density::ALL.into_iter().find(|d| d.name() == text);
    found.ok_or_else(|| "want sparse, medium or dense".to_owned())
}
