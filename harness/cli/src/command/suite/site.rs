//! `vb-harness suite import` and `suite site`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use vb_suite::generate::GeneratorParams;
use vb_suite::import::Source;
use vb_suite::site::{CourseSite, Cut, Site, SiteParams, Survey};
use vb_terrain::ElevationImage;
use vb_terrain::crs::Crs;
use vb_terrain::read::{Holes, Options, PICTURE, Said, is_course, short, survey};
use vb_world::{Georeference, Provenance, SuiteMeta};

use super::{must_be_free, rules, write};
use crate::args::values::positive;
use crate::error::CliError;
use crate::output;

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

/// Samples farther apart than this many nodes of a world can't have its roughness.
const COARSE: f64 = 2.0;

pub(crate) fn import(args: &ImportArgs) -> Result<(), CliError> {
    must_be_free(&args.out)?;
    let source = Source::find(&args.from).map_err(CliError::input)?.ground(args.ground.into());
    let worlds = source.ids().map(|id| source.world(id).map_err(CliError::input));
    write(&args.out, source.meta(), worlds)
}

pub(crate) fn make(args: &SiteArgs) -> Result<(), CliError> {
    must_be_free(&args.out)?;
    let rules_of_site = rules::<SiteParams>(args.site.as_deref())?;
    let params = rules::<GeneratorParams>(args.params.as_deref())?;
    if is_course(&args.raster) {
        return course(args, args.site.is_some().then_some(&rules_of_site), &params);
    }
    let file = args.raster.display();
    let options = Options {
        holes: Holes::Keep,
        unit: args.unit,
        no_data: args.no_data,
        keep: args.keep_values,
        resolution: args.sample_resolution,
        crs: args.crs.clone(),
        labels: false,
    };
    let found = survey(&args.raster, &options).map_err(CliError::input)?;
    output::note(&found.summary());
    for note in &found.notes {
        output::say(&format!("note: {note}"));
    }
    let heights = &found.heights;
    // Grey levels have no height of their own.
    let levels = found.format == PICTURE && matches!(found.unit_said, Said::Assumed(_));
    let resolution = match heights.resolution() {
        Some(resolution) if !levels => resolution,
        resolution => {
            let distance = "the sample spacing: give --sample-resolution, m";
            let distance = resolution.is_none().then_some(distance);
            let unit = levels.then_some("the height of a grey level: give --unit, m");
            let missing: Vec<_> = distance.into_iter().chain(unit).collect();
            return Err(CliError::usage(format!(
                "{file}: the file does not specify {}",
                missing.join(" and ")
            )));
        }
    };
    if resolution > COARSE * rules_of_site.resolution {
        output::say(&format!(
            "warning: a sample spacing of {} m is too coarse for the roughness of a benchmark world, which has nodes every {} m: \
             this world has no wavelengths below {} m, and is smoother than the site",
            short(resolution),
            rules_of_site.resolution,
            short(2.0 * resolution)
        ));
    }
    let labels = args.labels.as_deref().map(|path| labels(path, args.crs.as_ref())).transpose()?;
    let obstacles = args.obstacles.as_deref().map(vb_world::read_obstacles).transpose();
    let obstacles = obstacles.map_err(CliError::input)?;
    let survey = Survey {
        heights,
        resolution,
        labels: labels.as_ref(),
        obstacles: obstacles.as_deref(),
        any_relief: args.any_relief,
    };
    let cut = if args.tiles { Cut::Tiles } else { Cut::At(args.at) };
    let failed = |e| CliError::input(format!("{file}: {e}"));
    let site = Site::new(&survey, cut, args.density, &rules_of_site, &params, args.seed).map_err(failed)?;
    let name = |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let place = found.place.as_ref().and_then(|place| {
        let crs = place.crs.as_ref()?;
        let origins = site.centres().map(|(world, at)| (world, place.at(at))).collect();
        Some(Georeference { crs: crs.name.clone(), proj: crs.proj.clone(), metres: place.metres, origins })
    });
    let meta = SuiteMeta {
        name: name(&args.out),
        version: "1".into(),
        description: format!("{} worlds of the site in {}.", site.count(), name(&args.raster)),
        provenance: Provenance::Imported {
            source: format!(
                "{}, {:.3} by {:.3} m, site rules {}, rules {}, seed {}",
                name(&args.raster),
                heights.cols() as f64 * resolution,
                heights.rows() as f64 * resolution,
                rules_of_site.name,
                params.name,
                args.seed
            ),
            place,
        },
    };
    let worlds = site.worlds().enumerate().map(|(k, world)| {
        let world = world.map_err(failed)?;
        let (low, high) = world.heightfield.range();
        let elevation = world.elevation.name();
        output::note(&format!(
            "[{}/{}] {}: relief {:.1} m, elevation {elevation}",
            k + 1,
            site.count(),
            world.id,
            high - low
        ));
        Ok(world)
    });
    write(&args.out, meta, worlds)
}

/// Makes the world of a course. `site` are the rules of the user's, if there are any.
fn course(args: &SiteArgs, site: Option<&SiteParams>, params: &GeneratorParams) -> Result<(), CliError> {
    let given = [
        ("--sample-resolution", args.sample_resolution.is_some()),
        ("--unit", args.unit.is_some()),
        ("--no-data", args.no_data.is_some()),
        ("--keep-values", args.keep_values),
        ("--crs", args.crs.is_some()),
        ("--at", args.at != [0.0; 2]),
        ("--tiles", args.tiles),
        ("--labels", args.labels.is_some()),
    ];
    let file = args.raster.display();
    let given: Vec<&str> = given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect();
    if !given.is_empty() {
        return Err(CliError::usage(format!(
            "{file}: an OpenCRG course becomes one world; {} does not apply: omit it",
            given.join(", ")
        )));
    }
    let found = vb_terrain::read::course(&args.raster).map_err(CliError::input)?;
    output::note(&found.course.summary());
    for note in &found.notes {
        output::say(&format!("note: {note}"));
    }
    let obstacles = args.obstacles.as_deref().map(vb_world::read_obstacles).transpose();
    let obstacles = obstacles.map_err(CliError::input)?.unwrap_or_default();
    let failed = |e| CliError::input(format!("{file}: {e}"));
    let made =
        CourseSite::new(&found.course, &obstacles, args.density, site, params, args.seed).map_err(failed)?;
    let (side, resolution) = (made.side(), made.resolution());
    output::note(&format!(
        "a world of {side} m with nodes every {resolution} m, and a task along the course"
    ));
    if resolution > COARSE * found.course.increment() {
        output::say(&format!(
            "warning: a node spacing of {resolution} m is too coarse for a course with cross-sections every {} m: this world has no \
             wavelengths below {} m, and is smoother than the course",
            short(found.course.increment()),
            short(2.0 * resolution)
        ));
    }
    let name = |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let meta = SuiteMeta {
        name: name(&args.out),
        version: "1".into(),
        description: format!("The course in {}.", name(&args.raster)),
        provenance: Provenance::Imported {
            source: format!(
                "{}, {}, site rules {}, rules {}, seed {}",
                name(&args.raster),
                found.course.summary(),
                made.rules(),
                params.name,
                args.seed
            ),
            place: None,
        },
    };
    write(&args.out, meta, std::iter::once(made.world().map_err(failed)))
}

/// Labels of the ground, whose holes matter only where a world lies.
fn labels(path: &Path, crs: Option<&Crs>) -> Result<ElevationImage, CliError> {
    let options = Options { holes: Holes::Keep, labels: true, crs: crs.cloned(), ..Options::default() };
    Ok(survey(path, &options).map_err(CliError::input)?.heights)
}

#[cfg(test)]
mod tests {
    use super::super::SuiteCommand;
    use crate::cli::parse;
    use crate::command::Command;

    #[test]
    fn an_import_takes_each_ground_by_its_name_and_the_described_one_without() {
        use vb_suite::import::Ground as Made;
        let ground = |more: &[&str]| {
            let args = [&["suite", "import", "BenchMaps", "--out", "original"], more].concat();
            match parse(&args).unwrap() {
                Command::Suite(SuiteCommand::Import(args)) => Made::from(args.ground),
                other => panic!("{other:?}"),
            }
        };
        for wanted in Made::ALL {
            assert_eq!(ground(&["--ground", wanted.name()]), wanted);
        }
        assert_eq!(ground(&[]), Made::AsDescribed);
    }
}
