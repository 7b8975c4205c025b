//! Training worlds: drawn by the generator from seeds that no suite uses.

use std::path::Path;

use vb_suite::generate::{Generator, GeneratorParams, TRAINING_SEEDS};
use vb_terrain::Model;
use vb_world::Suite;

use crate::{Catalog, CatalogError, is_name};

impl Catalog {
    /// The terrain model that a generator's rules name: one that comes with the harness, or a file beside the rules' file.
    pub fn model(&self, name: &str, rules: Option<&Path>) -> Result<Model, CatalogError> {
        let wanted = Path::new(name);
        let path = if is_name(wanted.as_os_str()) {
            self.terrain_model(name)?
        } else {
            rules.and_then(Path::parent).unwrap_or(Path::new("")).join(wanted)
        };
        Model::read(&path).map_err(|e| CatalogError::Terrain(e.to_string()))
    }

    /// The suite of training worlds with this seed and number: where it was made before, or made now. `making` is called
    /// before it is made, which takes a second a world.
    ///
    /// # Errors
    /// Returns an error for a seed that isn't one of training worlds, and if the worlds can't be made or put away.
    pub fn training(&self, seed: u64, worlds: u32, making: &mut dyn FnMut()) -> Result<Suite, CatalogError> {
        if !TRAINING_SEEDS.contains(&seed) {
            return Err(CatalogError::NoTrainingSeed(seed));
        }
        let params = GeneratorParams::default();
        let model = self.model(&params.elevation.model, None)?;
        let generator = Generator { rules: &params, model: &model, seed, worlds: worlds as usize };
        let meta = generator.meta(&format!("training-{seed}"), "1");
        let cache = self.cache.clone().unwrap_or_else(std::env::temp_dir).join("training");
        // A newer generator makes other worlds of the same seed.
        let made_by = vb_files::sha256(format!("{:?}", meta.provenance).as_bytes());
        let dir = cache.join(format!("seed-{seed}-{worlds}-{}", &made_by[..12]));
        if dir.is_dir() {
            return Ok(Suite::open(&dir)?);
        }
        let failed = |source| CatalogError::Write { path: cache.clone(), source };
        std::fs::create_dir_all(&cache).map_err(failed)?;
        making();
        // Made elsewhere and then renamed, so that it is whole if it is there.
        let unfinished = tempfile::Builder::new().prefix(".making-").tempdir_in(&cache).map_err(failed)?;
        generator.write(unfinished.path().join("suite"), meta, |_, _| {})?;
        if let Err(e) = std::fs::rename(unfinished.path().join("suite"), &dir)
            // Another process may have been faster.
            && !dir.is_dir()
        {
            return Err(failed(e));
        }
        Ok(Suite::open(&dir)?)
    }
}
