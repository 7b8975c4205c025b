//! `vb-harness suite import` and `suite site`.

use std::path::Path;

use vb_suite::generate::GeneratorParams;
use vb_suite::import::Source;
use vb_suite::site::{CourseSite, Cut, Site, SiteParams, Survey};
use vb_terrain::ElevationImage;
use vb_terrain::crs::Crs;
use vb_terrain::read::{Holes, Options, PICTURE, Said, is_course, short, survey};
use vb_world::{Georeference, Provenance, SuiteMeta};

use crate::args::{ImportArgs, SiteArgs};
use crate::error::CliError;
use crate::output;
use crate::suite::{must_be_free, rules, write};

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
