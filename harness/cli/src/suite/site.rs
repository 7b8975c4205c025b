//! `vb-harness suite site`.

use std::path::Path;

use vb_suite::generate::GeneratorParams;
use vb_suite::site::{self, Cut, SiteParams, Survey};
use vb_terrain::ElevationImage;
use vb_terrain::read::{Holes, read};
use vb_world::{Provenance, SuiteMeta};

use crate::args::SiteArgs;
use crate::error::CliError;
use crate::suite::{rules, write};

pub(crate) fn make(args: &SiteArgs) -> Result<(), CliError> {
    let site = rules(args.site.as_deref(), SiteParams::parse)?;
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
    let worlds = site::worlds(&survey, cut, args.density, &site, &params, args.seed)
        .map_err(|e| CliError::input(format!("{file}: {e}")))?;
    let name = |path: &Path| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let meta = SuiteMeta {
        name: name(&args.out),
        version: "1".into(),
        description: format!("{} worlds of the place in {}.", worlds.len(), name(&args.raster)),
        provenance: Provenance::Imported {
            source: format!(
                "{}, {:.3} by {:.3} m, site rules {}, rules {}, seed {}",
                name(&args.raster),
                heights.cols() as f64 * resolution,
                heights.rows() as f64 * resolution,
                site.name,
                params.name,
                args.seed
            ),
        },
    };
    write(&args.out, meta, worlds.into_iter().map(Ok))
}

/// A raster whose holes matter only where a world lies.
fn raster(path: &Path) -> Result<ElevationImage, CliError> {
    read(path, Holes::Keep).map_err(CliError::input)
}
