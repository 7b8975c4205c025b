//! `vb-harness suite site`.

use std::path::Path;

use vb_suite::generate::GeneratorParams;
use vb_suite::site::{Cut, Site, SiteParams, Survey};
use vb_terrain::ElevationImage;
use vb_terrain::read::{Holes, read};
use vb_world::{Provenance, SuiteMeta};

use crate::args::SiteArgs;
use crate::error::CliError;
use crate::output;
use crate::suite::{must_be_free, rules, write};

pub(crate) fn make(args: &SiteArgs) -> Result<(), CliError> {
    must_be_free(&args.out)?;
    let rules_of_site = rules(args.site.as_deref(), SiteParams::parse)?;
    let params = rules(args.params.as_deref(), GeneratorParams::parse)?;
    let file = args.raster.display();
    let mut heights = raster(&args.raster)?;
    for z in heights.values_mut() {
        *z *= args.unit;
    }
    let Some(resolution) = args.sample_resolution.or(heights.resolution()) else {
        let message =
            format!("{file}: the file doesn't say how far apart its samples are: give --sample-resolution");
        return Err(CliError::usage(message));
    };
    let labels = args.labels.as_deref().map(raster).transpose()?;
    let obstacles = args.obstacles.as_deref().map(vb_world::read_obstacles).transpose();
    let obstacles = obstacles.map_err(CliError::input)?;
    let survey =
        Survey { heights: &heights, resolution, labels: labels.as_ref(), obstacles: obstacles.as_deref() };
    let cut = if args.tiles { Cut::Tiles } else { Cut::At(args.at.unwrap_or_default()) };
    let failed = |e| CliError::input(format!("{file}: {e}"));
    let site = Site::new(&survey, cut, args.density, &rules_of_site, &params, args.seed).map_err(failed)?;
    let name = |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let meta = SuiteMeta {
        name: name(&args.out),
        version: "1".into(),
        description: format!("{} worlds of the place in {}.", site.count(), name(&args.raster)),
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
        },
    };
    let worlds = site.worlds().enumerate().map(|(k, world)| {
        let world = world.map_err(failed)?;
        output::note(&format!("[{}/{}] {}", k + 1, site.count(), world.id));
        Ok(world)
    });
    write(&args.out, meta, worlds)
}

/// A raster whose holes matter only where a world lies.
fn raster(path: &Path) -> Result<ElevationImage, CliError> {
    read(path, Holes::Keep).map_err(CliError::input)
}
